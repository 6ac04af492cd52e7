//! Oracles of the feature family that need more than one of its files.

mod drawings;
mod plan;
mod ppa;
mod sketch;

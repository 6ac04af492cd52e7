//! Oracles of the feature family that need more than one of its files.

mod adherence;
mod classify;
mod drawings;
mod from_curves;
mod plan;
mod ppa;
mod sketch;

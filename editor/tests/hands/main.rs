//! The editor by its gestures, through the accessibility tree. One program, since each would link all of the editor.
#![allow(clippy::unwrap_used)]

mod common;

mod afar;
mod canvas;
mod gestures;
mod guide;
mod inspector;
mod menus;
mod newer;
mod painting;
mod panes;
mod random;
mod reload;
mod running;
mod settings;
mod sketching;
mod typed;
mod views;
mod words_and_wires;

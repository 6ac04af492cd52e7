//! Clicks that are over within one frame.
//!
//! A tap on a touchpad, a remote desktop or a slow frame can bring a press and its release together. Widgets that look
//! whether a button is down, as those of the graph do, would never see it, so the release waits for the next frame.

use eframe::egui::{Event, PointerButton};

/// What waits for the next frame.
#[derive(Default)]
pub(crate) struct Clicks {
    waiting: Vec<Event>,
}

impl Clicks {
    /// The events of this frame, given those that came; true when some wait for another.
    pub(crate) fn part(&mut self, came: &mut Vec<Event>) -> bool {
        let mut all = std::mem::take(&mut self.waiting);
        all.append(came);
        let mut down: Vec<PointerButton> = Vec::new();
        let release = all.iter().position(|event| match event {
            Event::PointerButton { button, pressed: true, .. } => {
                down.push(*button);
                false
            }
            Event::PointerButton { button, pressed: false, .. } => down.contains(button),
            _ => false,
        });
        if let Some(at) = release {
            self.waiting = all.split_off(at);
        }
        *came = all;
        !self.waiting.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Modifiers, pos2};

    use super::*;

    fn primary(pressed: bool) -> Event {
        let (pos, button, modifiers) = (pos2(1.0, 2.0), PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos, button, pressed, modifiers }
    }

    #[test]
    fn of_two_clicks_in_one_frame_every_press_and_release_has_its_own_and_nothing_is_lost() {
        let mut clicks = Clicks::default();
        let moved = Event::PointerMoved(pos2(1.0, 2.0));
        let mut came = vec![moved.clone(), primary(true), primary(false), primary(true), primary(false)];
        let mut frames = Vec::new();
        while clicks.part(&mut came) {
            frames.push(std::mem::take(&mut came));
        }
        frames.push(came);
        let expected =
            vec![vec![moved, primary(true)], vec![primary(false), primary(true)], vec![primary(false)]];
        assert_eq!(frames, expected);
    }

    #[test]
    fn what_a_hand_does_slowly_goes_straight_through() {
        let mut clicks = Clicks::default();
        for event in [primary(true), Event::PointerMoved(pos2(3.0, 4.0)), primary(false)] {
            let mut came = vec![event.clone()];
            assert!(!clicks.part(&mut came));
            assert_eq!(came, [event]);
        }
    }
}

//! Clicks that come faster than frames.
//!
//! A tap on a touchpad, a remote desktop or a slow frame can bring a press and its release together. Widgets that look
//! whether a button is down, as those of the graph do, would never see it, so the release waits for the next frame. A
//! tap on a touch screen can press where the pointer never was. What a press meets are the widgets of the frame before,
//! and of a large graph only those near the pointer are widgets, so such a press waits for a frame that knows its place.

use eframe::egui::{Event, PointerButton, Pos2};

/// So near to where the pointer was, in the window, a press is at a known place.
const NEAR: f32 = 24.0;

/// What waits for the next frame.
#[derive(Default)]
pub(crate) struct Clicks {
    waiting: Vec<Event>,
    /// Where the pointer was in the last frame.
    seen: Option<Pos2>,
}

impl Clicks {
    /// The events of this frame, given those that came; true when some wait for another.
    pub(crate) fn part(&mut self, came: &mut Vec<Event>) -> bool {
        let mut all = std::mem::take(&mut self.waiting);
        all.append(came);
        let mut down: Vec<PointerButton> = Vec::new();
        let known = |pos: Pos2| self.seen.is_some_and(|seen| seen.distance(pos) <= NEAR);
        let late = all.iter().position(|event| match event {
            Event::PointerButton { button, pressed: true, pos, .. } => {
                down.push(*button);
                !known(*pos)
            }
            Event::PointerButton { button, pressed: false, .. } => down.contains(button),
            _ => false,
        });
        if let Some(at) = late {
            self.waiting = all.split_off(at);
            if let Event::PointerButton { pressed: true, pos, .. } = self.waiting[0] {
                all.push(Event::PointerMoved(pos));
            }
        }
        for event in &all {
            match event {
                Event::PointerMoved(pos) | Event::PointerButton { pos, .. } => self.seen = Some(*pos),
                Event::PointerGone => self.seen = None,
                _ => {}
            }
        }
        *came = all;
        !self.waiting.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Modifiers, pos2};

    use super::*;

    fn at(pos: Pos2, pressed: bool) -> Event {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos, button, pressed, modifiers }
    }

    fn primary(pressed: bool) -> Event {
        at(pos2(1.0, 2.0), pressed)
    }

    fn frames(clicks: &mut Clicks, mut came: Vec<Event>) -> Vec<Vec<Event>> {
        let mut frames = Vec::new();
        while clicks.part(&mut came) {
            frames.push(std::mem::take(&mut came));
        }
        frames.push(came);
        frames
    }

    #[test]
    fn of_two_clicks_in_one_frame_every_press_and_release_has_its_own_and_nothing_is_lost() {
        let mut clicks = Clicks::default();
        let moved = Event::PointerMoved(pos2(1.0, 2.0));
        assert!(!clicks.part(&mut vec![moved.clone()]));
        let came = vec![moved.clone(), primary(true), primary(false), primary(true), primary(false)];
        let expected =
            vec![vec![moved, primary(true)], vec![primary(false), primary(true)], vec![primary(false)]];
        assert_eq!(frames(&mut clicks, came), expected);
    }

    #[test]
    fn what_a_hand_does_slowly_goes_straight_through() {
        let mut clicks = Clicks::default();
        for event in [
            Event::PointerMoved(pos2(1.0, 2.0)),
            primary(true),
            Event::PointerMoved(pos2(300.0, 4.0)),
            at(pos2(300.0, 4.0), false),
        ] {
            assert_eq!(frames(&mut clicks, vec![event.clone()]), [[event]]);
        }
    }

    #[test]
    fn a_press_where_the_pointer_never_was_waits_for_a_frame_with_the_pointer_there() {
        let mut clicks = Clicks::default();
        let far = pos2(500.0, 300.0);
        let moved = Event::PointerMoved(far);
        let expected = vec![vec![moved.clone()], vec![at(far, true)], vec![at(far, false)]];
        assert_eq!(frames(&mut clicks, vec![at(far, true), at(far, false)]), expected);
        // A finger that was lifted leaves no place.
        assert!(!clicks.part(&mut vec![Event::PointerGone]));
        assert_eq!(frames(&mut clicks, vec![at(far, true), at(far, false)]), expected);
    }
}

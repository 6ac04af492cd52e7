//! How long work probably still takes, from the share that is done.

/// Seconds in which nothing is said: what is over soon needs no words.
const QUIET: f64 = 1.0;

/// The share below which nothing is said: so little says nothing about the rest.
const LITTLE: f64 = 0.03;

/// Seconds within which an estimate follows what is newly learnt.
const SMOOTHING: f64 = 3.0;

/// An estimate of how long one piece of work still takes. It is fed with times, and reads no clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeLeft {
    at_hand: Option<AtHand>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct AtHand {
    begun: f64,
    share: f64,
    looked: f64,
    /// When the work will be over, as far as one can tell.
    end: Option<f64>,
}

impl TimeLeft {
    /// Learns that at `now`, in seconds, `share` of the work is done; what came late and says less counts for nothing.
    /// The first time begins the work.
    pub fn learn(&mut self, share: f64, now: f64) {
        let at_hand = self.at_hand.unwrap_or(AtHand { begun: now, share: 0.0, looked: now, end: None });
        let share = share.clamp(at_hand.share, 1.0);
        let spent = now - at_hand.begun;
        let told = (share > at_hand.share || at_hand.end.is_none()) && share >= LITTLE && spent > 0.0;
        let end = match at_hand.end {
            _ if !told => at_hand.end,
            None => Some(at_hand.begun + spent / share),
            Some(before) => {
                let learnt = at_hand.begun + spent / share;
                let weight = 1.0 - libm::exp(-(now - at_hand.looked).max(0.0) / SMOOTHING);
                Some(before + (learnt - before) * weight)
            }
        };
        let looked = if told { now } else { at_hand.looked };
        self.at_hand = Some(AtHand { share, looked, end, ..at_hand });
    }

    /// Forgets the work: it is over, or gave way to other work.
    pub fn over(&mut self) {
        self.at_hand = None;
    }

    /// How long it still takes, in words; nothing while that cannot be told.
    #[must_use]
    pub fn words(&self, now: f64) -> Option<String> {
        let at_hand = self.at_hand?;
        let end = at_hand.end.filter(|_| now - at_hand.begun >= QUIET)?;
        Some(in_words(end - now))
    }
}

fn in_words(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round();
    if seconds <= 5.0 {
        "a few seconds left".into()
    } else if seconds < 57.5 {
        format!("about {} s left", 5.0 * (seconds / 5.0).round())
    } else if minutes < 60.0 {
        format!("about {} min left", minutes.max(1.0))
    } else {
        let hours = libm::floor(minutes / 60.0);
        match libm::floor((minutes - 60.0 * hours) / 10.0) {
            0.0 => format!("about {hours} h left"),
            tens => format!("about {hours} h {} min left", 10.0 * tens),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is told at each second of a work of which so much is done.
    fn told(shares: &[f64]) -> Vec<Option<String>> {
        let mut left = TimeLeft::default();
        let seconds = (0u32..).map(f64::from);
        let each = shares.iter().zip(seconds).map(|(share, now)| {
            left.learn(*share, now);
            left.words(now)
        });
        each.collect()
    }

    #[test]
    fn work_that_gets_on_evenly_is_told_to_the_second() {
        let shares: Vec<f64> = (0..=100).map(|second| f64::from(second) / 100.0).collect();
        let told = told(&shares);
        assert_eq!(told[..3], [None, None, None], "nothing below three percent");
        assert_eq!(told[10].as_deref(), Some("about 2 min left"));
        assert_eq!(told[40].as_deref(), Some("about 1 min left"));
        assert_eq!(told[60].as_deref(), Some("about 40 s left"));
        assert_eq!(told[97].as_deref(), Some("a few seconds left"));
    }

    #[test]
    fn nothing_is_told_in_the_first_second() {
        let mut left = TimeLeft::default();
        left.learn(0.0, 10.0);
        left.learn(0.5, 10.9);
        assert_eq!(left.words(10.9), None);
        assert!(left.words(11.1).is_some());
    }

    #[test]
    fn while_nothing_is_heard_the_time_runs_down_and_never_below_nothing() {
        let mut left = TimeLeft::default();
        left.learn(0.0, 0.0);
        left.learn(0.5, 30.0);
        assert_eq!(left.words(30.0).as_deref(), Some("about 30 s left"));
        left.learn(0.5, 40.0);
        assert_eq!(left.words(40.0).as_deref(), Some("about 20 s left"));
        assert_eq!(left.words(500.0).as_deref(), Some("a few seconds left"));
    }

    #[test]
    fn a_jump_does_not_throw_the_estimate_about() {
        let mut left = TimeLeft::default();
        for second in 0..=20u32 {
            left.learn(f64::from(second) / 100.0, f64::from(second));
        }
        // A tenth of the work is done in no time: 46 s were left at this pace instead of 80.
        left.learn(0.3, 20.1);
        assert_eq!(left.words(20.1).as_deref(), Some("about 1 min left"));
        for second in 21..=40u32 {
            left.learn(0.3 + f64::from(second - 20) / 100.0, f64::from(second));
        }
        assert_eq!(left.words(40.0).as_deref(), Some("about 40 s left"));
    }

    #[test]
    fn what_comes_late_counts_for_nothing_and_other_work_begins_anew() {
        let mut left = TimeLeft::default();
        left.learn(0.0, 0.0);
        left.learn(0.5, 30.0);
        let before = left;
        left.learn(0.4, 30.0);
        assert_eq!(left, before);
        left.over();
        assert_eq!(left.words(30.0), None);
        left.learn(0.0, 31.0);
        left.learn(0.2, 33.0);
        assert_eq!(left.words(33.0).as_deref(), Some("about 10 s left"));
    }

    #[test]
    fn long_times_are_told_roughly() {
        for (seconds, words) in [
            (-3.0, "a few seconds left"),
            (42.0, "about 40 s left"),
            (59.0, "about 1 min left"),
            (185.0, "about 3 min left"),
            (3600.0, "about 1 h left"),
            (3600.0 * 2.0 + 60.0 * 44.0, "about 2 h 40 min left"),
        ] {
            assert_eq!(in_words(seconds), words);
        }
    }
}

//! Tells of a run while it goes on: how nodes stand, and how far the work is.

use std::sync::{Arc, mpsc::Sender};

use orograph_core::Error;
use orograph_engine::{Observer, Outcome, eval::Event};

use crate::runner::{Badge, Fault, News};

/// What a run is part of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Work {
    /// One of many wishes, of which some are met.
    Wish { met: usize, of: usize },
    /// A build, which is one run.
    Build,
}

impl Work {
    /// How far the whole work is when so much of the run is done.
    pub(crate) fn share(self, overall: f64) -> News {
        match self {
            Self::Wish { met, of } => {
                News::Progress((met as f64 + overall.clamp(0.0, 1.0)) / of.max(1) as f64)
            }
            Self::Build => News::Building(overall),
        }
    }

    /// The first and the second half of it, for what takes two runs.
    pub(crate) fn halves(self) -> [Self; 2] {
        match self {
            Self::Wish { met, of } => [2 * met, 2 * met + 1].map(|met| Self::Wish { met, of: 2 * of }),
            Self::Build => [self; 2],
        }
    }

    /// Whether badges on nodes tell of it: those of a preview stand for what is seen.
    fn has_badges(self) -> bool {
        matches!(self, Self::Wish { .. })
    }
}

/// Sends what a run tells as news of a round.
pub(crate) struct Teller {
    pub(crate) number: u64,
    pub(crate) work: Work,
    pub(crate) sender: Sender<(u64, News)>,
    pub(crate) wake: Arc<dyn Fn() + Send + Sync>,
}

impl Observer for Teller {
    fn event(&self, event: &Event<'_>) {
        let (badge, overall) = match event {
            Event::Started { node } => (Some((*node, Badge::Running(0.0))), None),
            Event::Progress { node, done, overall } => (Some((*node, Badge::Running(*done))), Some(*overall)),
            Event::Finished { node, outcome, overall } => (failed(node, outcome), Some(*overall)),
            Event::Note { .. } => return,
        };
        let badge = badge.filter(|(node, _)| self.work.has_badges() && !is_look(node));
        let badge = badge.map(|(node, badge)| News::Node(outermost(node).to_owned(), badge));
        for news in badge.into_iter().chain(overall.map(|overall| self.work.share(overall))) {
            // Nobody listens any more when the window is gone.
            let _ = self.sender.send((self.number, news));
        }
        (self.wake)();
    }
}

/// How a node stands that is over: what it came to is told by the report, unless it failed.
fn failed<'a>(node: &'a str, outcome: &Outcome) -> Option<(&'a str, Badge)> {
    match outcome {
        Outcome::Failed(error) if *error != Error::Cancelled => {
            let of = Some(outermost(node).to_owned());
            Some((node, Badge::Failed(Fault { node: of, message: error.to_string(), help: error.hint() })))
        }
        _ => None,
    }
}

/// How the names of nodes begin that make pictures; no node of a document can have such a name.
pub(crate) const LOOK: &str = "a look at it";

pub(crate) fn is_look(name: &str) -> bool {
    name.starts_with(LOOK)
}

/// The node of the document that a node of the flat graph belongs to.
pub(crate) fn outermost(name: &str) -> &str {
    name.split('/').next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn the_share_of_a_round_grows_from_wish_to_wish() {
        let (sender, news) = mpsc::channel();
        for met in 0..4 {
            let work = Work::Wish { met, of: 4 };
            let teller = Teller { number: 3, work, sender: sender.clone(), wake: Arc::new(|| ()) };
            for overall in [0.25, 1.0] {
                teller.event(&Event::Progress { node: "hills", done: overall, overall });
            }
        }
        let shares: Vec<f64> = news
            .try_iter()
            .filter_map(|(_, news)| match news {
                News::Progress(share) => Some(share),
                _ => None,
            })
            .collect();
        assert_eq!(shares.len(), 8);
        assert!(shares.is_sorted(), "{shares:?}");
        assert_eq!((shares[0], shares[7]), (0.0625, 1.0));
    }

    #[test]
    fn the_halves_of_a_wish_follow_each_other() {
        let [first, second] = Work::Wish { met: 1, of: 4 }.halves();
        let share = |work: Work, overall| match work.share(overall) {
            News::Progress(share) => share,
            other => panic!("{other:?}"),
        };
        assert_eq!([share(first, 0.0), share(first, 1.0)], [0.25, 0.375]);
        assert_eq!([share(second, 0.0), share(second, 1.0)], [0.375, 0.5]);
    }

    #[test]
    fn a_build_tells_its_share_and_leaves_the_badges_of_the_preview_alone() {
        let (sender, news) = mpsc::channel();
        let teller = Teller { number: 0, work: Work::Build, sender, wake: Arc::new(|| ()) };
        teller.event(&Event::Started { node: "hills" });
        teller.event(&Event::Progress { node: "hills", done: 0.5, overall: 0.25 });
        let told: Vec<_> = news.try_iter().map(|(_, news)| news).collect();
        assert!(matches!(told[..], [News::Building(0.25)]), "{told:?}");
    }
}

//! The rows of a section on their way: what each member has made so far, and what it makes next.

use std::time::Instant;

use orograph_core::{Band, BandSink, BandSource, Collected, Error, Grid, Job, Result, Slot, Value, rows_of};

use super::{
    host::MemberHost,
    section::{Member, Role, Section, Wire},
};
use crate::eval::{call::call, report::Outcome};

/// Bytes that the newest rows of all members may take together at most: enough that rows computed twice, at the edges of
/// bands, do not count.
const TOGETHER: u64 = 64 << 20;
/// And at most this part of the memory that the run was given.
const PART: u64 = 8;
/// A band has at least this many rows.
const LEAST_ROWS: usize = 32;
/// And this many times the halo of the node that looks farthest.
const LEAST_HALOS: usize = 4;

/// A section at work.
pub(super) struct Tracks<'a> {
    section: &'a Section,
    job: &'a Job<'a>,
    slots: &'a [Slot],
    /// The rasters that come from outside; nothing for other values.
    outside: Vec<Vec<Band>>,
    hands: Vec<Hand>,
    /// Every raster has the same rows and columns. Otherwise members run one after another on whole rasters, and say by
    /// themselves what does not fit.
    even: bool,
}

/// What one member has in hand.
struct Hand {
    source: Option<Box<dyn BandSource>>,
    sink: Option<Box<dyn BandSink>>,
    /// Of what it makes, or writes.
    grid: Grid,
    /// Rows beyond its own that it looks at.
    halo: usize,
    /// Members that take what it makes.
    takers: Vec<usize>,
    /// Rows that it has made.
    done: usize,
    /// For each output, the rows that are still needed.
    kept: Vec<Vec<Band>>,
    /// For each output, the whole, where that is wanted.
    whole: Vec<Collected>,
    /// It made no more rows, or could not, for what it needs failed.
    failed: Option<Outcome>,
}

impl<'a> Tracks<'a> {
    pub(super) fn new(section: &'a Section, slots: &'a [Slot], job: &'a Job<'a>) -> Result<Self> {
        let outside = slots.iter().map(|slot| match slot {
            Slot::One(value) if value.grid().is_some() => vec![Band { first: 0, value: value.clone() }],
            _ => Vec::new(),
        });
        let mut tracks =
            Self { section, job, slots, outside: outside.collect(), hands: Vec::new(), even: true };
        for member in 0..section.members().len() {
            let hand = at_work(section, member, job, |job| tracks.hand(member, job))?;
            tracks.hands.push(hand);
            for wire in section.members()[member].inputs.iter().flatten() {
                if let Wire::Member { member: from, .. } = *wire {
                    tracks.hands[from].takers.push(member);
                }
            }
        }
        let size = tracks.hands.first().map(|hand| hand.grid.size());
        let outside = tracks.outside.iter().flatten().filter_map(|band| band.value.grid());
        let mut grids = tracks.hands.iter().map(|hand| &hand.grid).chain(outside);
        tracks.even = grids.all(|grid| Some(grid.size()) == size);
        Ok(tracks)
    }

    /// What a member begins with.
    fn hand(&self, index: usize, job: &Job) -> Result<Hand> {
        let member = &self.section.members()[index];
        let source = match member.role {
            Role::Source => member.instance.source(job)?,
            _ => None,
        };
        let rasters: Vec<&Grid> =
            member.inputs.iter().flatten().filter_map(|&wire| self.grid(wire)).collect();
        let made = source.as_ref().map(|source| source.grid()).or(rasters.first().copied());
        let grid = made.cloned().ok_or_else(|| unkept("it gives no rows"))?;
        // A file that cannot be begun stops no other.
        let (sink, failed) = match member.role {
            Role::Sink => match member.instance.sink(&grid, job) {
                Ok(sink) => (Some(sink), None),
                Err(error) => (None, Some(Outcome::Failed(error))),
            },
            _ => (None, None),
        };
        let halo = match member.role {
            Role::Local => rasters.iter().map(|grid| member.instance.halo(grid.cell)).max().unwrap_or(0),
            _ => 0,
        };
        let mut whole = Vec::new();
        for of in member.outputs.iter().filter(|_| member.collected) {
            whole.extend(Collected::new(*of, grid.clone(), job)?);
        }
        let kept = vec![Vec::new(); member.outputs.len()];
        Ok(Hand { source, sink, grid, halo, takers: Vec::new(), done: 0, kept, whole, failed })
    }

    fn grid(&self, wire: Wire) -> Option<&Grid> {
        match wire {
            Wire::Outside(wire) => self.outside[wire].first()?.value.grid(),
            Wire::Member { member, .. } => Some(&self.hands[member].grid),
        }
    }

    /// Goes down the rows; the values wanted whole. What does not depend on a member that failed is finished.
    pub(super) fn run(mut self) -> Result<Vec<Value>> {
        let rows = self.hands.iter().map(|hand| hand.grid.rows).max().unwrap_or(0);
        let step = if self.even { self.rows_of_a_band() } else { rows };
        let mut target = 0;
        while target < rows {
            self.job.check()?;
            target = target.saturating_add(step).min(rows);
            for (member, end) in self.ends(target).into_iter().enumerate() {
                self.try_to(member, |tracks, job| tracks.advance(member, end, job))?;
            }
            self.let_go();
            self.job.progress(target as f64 / rows as f64);
        }
        for member in 0..self.hands.len() {
            self.try_to(member, |tracks, job| {
                tracks.hands[member].sink.take().map_or(Ok(()), |sink| sink.finish(job))
            })?;
        }
        for (member, hand) in self.hands.iter().enumerate() {
            self.section.ended(member, hand.failed.clone().unwrap_or(Outcome::Streamed));
        }
        let error = self.hands.iter().find_map(|hand| match &hand.failed {
            Some(Outcome::Failed(error)) => Some(error.clone()),
            _ => None,
        });
        match error {
            Some(error) => Err(error),
            None => {
                Ok(self.hands.into_iter().flat_map(|hand| hand.whole).map(Collected::into_value).collect())
            }
        }
    }

    fn rows_of_a_band(&self) -> usize {
        let cols = self.hands.first().map_or(1, |hand| hand.grid.cols).max(1);
        let rasters = self.hands.iter().map(|hand| hand.kept.len()).sum::<usize>().max(1);
        let halo = self.hands.iter().map(|hand| hand.halo).max().unwrap_or(0);
        let bytes = usize::try_from((self.job.memory_limit() / PART).min(TOGETHER)).unwrap_or(usize::MAX);
        (bytes / (4 * cols * rasters)).max(LEAST_ROWS).max(halo.saturating_mul(LEAST_HALOS))
    }

    /// Up to which row each member has to be for those that nobody takes from to be at row `target`.
    fn ends(&self, target: usize) -> Vec<usize> {
        let mut ends = vec![0_usize; self.hands.len()];
        for member in (0..self.hands.len()).rev() {
            let hand = &self.hands[member];
            let rows = hand.grid.rows;
            let asked = hand.takers.iter().map(|&taker| match self.even {
                true => ends[taker].saturating_add(self.hands[taker].halo),
                false => rows,
            });
            let step = hand.source.as_ref().map_or(1, |source| source.step().max(1));
            ends[member] = asked.max().unwrap_or(0).max(target).next_multiple_of(step).min(rows);
        }
        ends
    }

    /// Lets a member do something, unless it failed before; the error when the run is to end.
    fn try_to(&mut self, member: usize, does: impl FnOnce(&mut Self, &Job) -> Result<()>) -> Result<()> {
        let hands = &self.hands;
        let mut needed = self.section.members()[member].inputs.iter().flatten();
        let broken = needed.find_map(|wire| match *wire {
            Wire::Member { member, .. } => hands[member].failed.as_ref().map(|outcome| (member, outcome)),
            Wire::Outside(_) => None,
        });
        if let Some((needed, outcome)) = broken {
            let because = match outcome {
                Outcome::Skipped { because } => because.clone(),
                _ => self.section.members()[needed].node.name.clone(),
            };
            self.hands[member].fail(Outcome::Skipped { because });
        }
        if self.hands[member].failed.is_some() {
            return Ok(());
        }
        let (section, job) = (self.section, self.job);
        match at_work(section, member, job, |job| does(self, job)) {
            Err(Error::Cancelled) => Err(Error::Cancelled),
            Err(error) => {
                self.hands[member].fail(Outcome::Failed(error));
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    /// Brings a member to row `end`.
    fn advance(&mut self, index: usize, end: usize, job: &Job) -> Result<()> {
        let section = self.section;
        let (member, start) = (&section.members()[index], self.hands[index].done);
        if end <= start {
            return Ok(());
        }
        match member.role {
            Role::Source => {
                let source = self.hands[index].source.as_ref().ok_or_else(|| unkept("it gives no rows"))?;
                let value = source.band(start, end - start, job)?;
                self.keep(index, 0, Band { first: start, value })?;
            }
            Role::Local => {
                let (halo, rows) = (self.hands[index].halo, self.hands[index].grid.rows);
                let (from, to) = (start.saturating_sub(halo), end.saturating_add(halo).min(rows));
                let slots = self.slots_of(member, from, to, job)?;
                let values = call(&member.node, &slots, job).map_err(|error| moved(error, from))?;
                drop(slots);
                for (output, value) in values.into_iter().enumerate() {
                    let band = Band { first: from, value };
                    if band.end() != to {
                        return Err(unkept("it is local, but an output has another grid than the input"));
                    }
                    let value = rows_of(&[band], start, end, job)?;
                    self.keep(index, output, Band { first: start, value })?;
                }
            }
            Role::Sink => {
                for slot in self.slots_of(member, start, end, job)? {
                    if let (Slot::One(band), Some(sink)) = (&slot, &mut self.hands[index].sink) {
                        sink.take(band, job)?;
                    }
                }
            }
        }
        self.hands[index].done = end;
        Ok(())
    }

    /// The rows `from` to before `to` of a member's inputs, other values as they are.
    fn slots_of(&self, member: &Member, from: usize, to: usize, job: &Job) -> Result<Vec<Slot>> {
        let rows = |bands: &[Band], grid: &Grid| match self.even {
            true => rows_of(bands, from, to, job),
            false => rows_of(bands, 0, grid.rows, job),
        };
        let value = |wire: &Wire| match *wire {
            Wire::Outside(wire) => match (&self.slots[wire], self.outside[wire].first()) {
                (_, Some(band)) => match band.value.grid() {
                    Some(grid) => rows(&self.outside[wire], grid),
                    None => Ok(band.value.clone()),
                },
                (Slot::One(value), None) => Ok(value.clone()),
                _ => Err(unkept("a wire into its section carries nothing")),
            },
            Wire::Member { member, output } => {
                rows(&self.hands[member].kept[output], &self.hands[member].grid)
            }
        };
        let slot = |wires: &Vec<Wire>| {
            Ok(match wires.as_slice() {
                [] => Slot::Empty,
                [wire] => Slot::One(value(wire)?),
                wires => Slot::Many(wires.iter().map(value).collect::<Result<_>>()?),
            })
        };
        member.inputs.iter().map(slot).collect()
    }

    /// Keeps new rows for those who take them.
    fn keep(&mut self, member: usize, output: usize, band: Band) -> Result<()> {
        let hand = &mut self.hands[member];
        if let Some(whole) = hand.whole.get_mut(output) {
            whole.take(&band.value)?;
        }
        if !hand.takers.is_empty() {
            hand.kept[output].push(band);
        }
        Ok(())
    }

    /// Lets go of the rows that nobody will look at again.
    fn let_go(&mut self) {
        for member in 0..self.hands.len() {
            let takers = self.hands[member].takers.iter().map(|&taker| &self.hands[taker]);
            let living = takers.filter(|taker| taker.failed.is_none());
            let first = living.map(|taker| taker.done.saturating_sub(taker.halo)).min().unwrap_or(usize::MAX);
            for kept in &mut self.hands[member].kept {
                kept.retain(|band| band.end() > first);
            }
        }
    }
}

impl Hand {
    fn fail(&mut self, outcome: Outcome) {
        self.failed.get_or_insert(outcome);
        // An output that was begun goes away, and memory is let go.
        self.sink = None;
        self.kept.iter_mut().for_each(Vec::clear);
    }
}

/// Lets a member do something on its own job, whose time and remarks are noted.
fn at_work<T>(
    section: &Section,
    member: usize,
    job: &Job,
    does: impl FnOnce(&Job) -> Result<T>,
) -> Result<T> {
    let part = section.goes_to(member);
    let host = MemberHost::new(job, &part.node);
    let begun = Instant::now();
    let result = does(&Job::new(&host, part.context));
    section.note(member, begun.elapsed(), host.into_warnings());
    result
}

/// The error of a node that was given rows from row `from` on, as the user counts rows.
fn moved(error: Error, from: usize) -> Error {
    match error {
        Error::NonFinite { what, row, col } => Error::NonFinite { what, row: row + from, col },
        other => other,
    }
}

fn unkept(what: &str) -> Error {
    Error::invalid(format!("the node does not keep its contract: {what}"), "report it to the node's author")
}

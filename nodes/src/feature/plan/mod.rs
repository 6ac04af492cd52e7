//! Placement plan: which patch comes where, and in which order.
//!
//! Zhou et al. (2007), section 4: a tree search from an isolated feature; patches on branch points and ends, and every
//! half patch along the lines between. Departures: paths are spread evenly, so that steps are never longer than half
//! a patch; a ring that polygon breaking opened gets a patch on its gap, and its ends none of their own.

mod roots;

use std::collections::VecDeque;

use orograph_core::{Column, Unit, prelude::*};

use self::roots::{components, sorted};
use super::network::{Arm, Incidence, Network};
use crate::PatchSize;

/// In which order patches are placed.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Along the lines, from branch points outward, tree by tree.
    TreeBfs,
    /// The same patches, row by row.
    RasterItems,
    /// A regular grid of patches that knows nothing of the lines.
    Raster,
}

/// Plans the order in which patches of terrain are placed along a network of lines.
#[derive(Params, Clone, Debug)]
pub struct Plan {
    /// The patches.
    #[param(flatten)]
    pub patches: PatchSize,
    /// In which order patches are placed.
    #[param(default = Order::TreeBfs)]
    pub order: Order,
}

/// Inputs of [`Plan`].
#[derive(Inputs)]
pub struct PlanIn<'a> {
    /// The ridges or valleys to place patches on.
    pub features: &'a Features,
}

/// Outputs of [`Plan`].
#[derive(Outputs)]
pub struct PlanOut {
    /// One row for each patch, in order: kind, row and column of its centre, number of arms, the patch before it on
    /// its tree, and the tree.
    pub plan: Table,
}

impl Node for Plan {
    const ID: &'static str = "feature.plan";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = PlanIn<'a>;
    type Outputs = PlanOut;

    fn run(&self, inputs: PlanIn<'_>, job: &Job) -> Result<PlanOut> {
        let items = plan(inputs.features, f64::from(self.patches.patch), self.order, job)?;
        if items.is_empty() {
            job.warn("there is nothing to place: the features have no lines");
        }
        let numbers = |name: &str, unit, of: &dyn Fn(usize, &Item) -> f64| Column {
            name: name.into(),
            unit,
            cells: Cells::Numbers(items.iter().enumerate().map(|(i, item)| of(i, item)).collect()),
        };
        let number = |at: Option<usize>| at.map_or(f64::NAN, |at| at as f64);
        let kinds = items.iter().map(|item| item.kind.name().to_owned()).collect();
        let plan = Table::new(vec![
            numbers("order", Unit::One, &|i, _| i as f64),
            Column { name: "kind".into(), unit: Unit::One, cells: Cells::Texts(kinds) },
            numbers("row", Unit::Cell, &|_, item| item.centre[0]),
            numbers("col", Unit::Cell, &|_, item| item.centre[1]),
            numbers("arms", Unit::One, &|_, item| item.arms.len() as f64),
            numbers("parent", Unit::One, &|_, item| number(item.parent)),
            numbers("component", Unit::One, &|_, item| number(item.component)),
        ])?;
        Ok(PlanOut { plan })
    }
}

/// What a patch lies on, which says how it is matched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemKind {
    /// Three or more lines meet.
    Branch,
    /// A line ends.
    End,
    /// A line passes.
    Path,
    /// The gap where a ring was opened; a line passes it.
    Ring,
    /// Nothing in particular.
    Plain,
}

impl ItemKind {
    /// The kind as tables have it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Branch => "branch",
            Self::End => "end",
            Self::Path => "path",
            Self::Ring => "ring",
            Self::Plain => "plain",
        }
    }
}

/// Where on the network a patch lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// On a point, by index.
    Point(usize),
    /// On a line, by index, at this length along it.
    Line(usize, f64),
    /// On the gap of a ring, by index.
    Ring(usize),
    /// Nowhere.
    Plain,
}

/// A patch to be placed.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// What it lies on.
    pub kind: ItemKind,
    /// Row and column of its centre.
    pub centre: [f64; 2],
    /// The lines that leave it, by ascending angle; their positions are the control points beside the centre. A path's
    /// first arm leads to its line's start.
    pub arms: Vec<Arm>,
    /// Where it lies on the network.
    pub place: Place,
    /// The patch before it on its tree, by its number in the plan; only in the order of the tree.
    pub parent: Option<usize>,
    /// Number of its tree.
    pub component: Option<usize>,
}

/// Radius of the circle inside a patch of `patch` cells, on which control points lie.
#[must_use]
pub fn radius(patch: f64) -> f64 {
    (patch - 1.0) / 2.0
}

/// The patches to be placed, in order; those whose centre leaves the grid are left out.
///
/// # Errors
/// As [`Network::new`]; [`Error::Cancelled`].
pub fn plan(features: &Features, patch: f64, order: Order, job: &Job) -> Result<Vec<Item>> {
    if order == Order::Raster {
        return Ok(regular(&features.grid, patch));
    }
    let network = Network::new(features)?;
    let mut planner = Planner::new(&network, patch);
    let components = components(&network);
    for (number, component) in sorted(&network, components, patch).into_iter().enumerate() {
        job.check()?;
        planner.component(number, &component);
    }
    let mut items = inside(planner.items, &features.grid);
    if order == Order::RasterItems {
        let band = |item: &Item| (item.centre[0] / (patch / 2.0)).floor();
        items.sort_by(|a, b| band(a).total_cmp(&band(b)).then_with(|| a.centre[1].total_cmp(&b.centre[1])));
        items.iter_mut().for_each(|item| item.parent = None);
    }
    Ok(items)
}

/// Leaves out items outside the grid; their children hang on what stays before them.
fn inside(items: Vec<Item>, grid: &Grid) -> Vec<Item> {
    let within = |item: &Item| {
        let [row, col] = item.centre;
        (-0.5..=grid.rows as f64 - 0.5).contains(&row) && (-0.5..=grid.cols as f64 - 0.5).contains(&col)
    };
    let mut numbers: Vec<Option<usize>> = Vec::with_capacity(items.len());
    let mut kept: Vec<Item> = Vec::with_capacity(items.len());
    for mut item in items {
        item.parent = item.parent.and_then(|parent| numbers[parent]);
        if within(&item) {
            numbers.push(Some(kept.len()));
            kept.push(item);
        } else {
            numbers.push(item.parent);
        }
    }
    kept
}

/// A grid of patches two thirds of a patch apart.
fn regular(grid: &Grid, patch: f64) -> Vec<Item> {
    let step = 2.0 * patch / 3.0;
    let along = |n: usize| {
        let steps = ((n as f64 - patch) / step).ceil().max(0.0) as usize;
        (0..=steps).map(move |i| radius(patch).min((n as f64 - 1.0) / 2.0) + i as f64 * step)
    };
    if grid.is_empty() {
        return Vec::new();
    }
    let item = |row: f64, col: f64| Item {
        kind: ItemKind::Plain,
        centre: [row.min(grid.rows as f64 - 1.0), col.min(grid.cols as f64 - 1.0)],
        arms: Vec::new(),
        place: Place::Plain,
        parent: None,
        component: None,
    };
    along(grid.rows)
        .flat_map(|row| along(grid.cols).map(move |col| (row, col)))
        .map(|(r, c)| item(r, c))
        .collect()
}

struct Planner<'a> {
    network: &'a Network<'a>,
    patch: f64,
    items: Vec<Item>,
    /// For each point whether the search came to it.
    seen: Vec<bool>,
    /// For each line whether the search went along it.
    passed: Vec<bool>,
}

impl<'a> Planner<'a> {
    fn new(network: &'a Network<'a>, patch: f64) -> Self {
        let features = network.features();
        let (seen, passed) = (vec![false; features.points.len()], vec![false; features.lines.len()]);
        Self { network, patch, items: Vec::new(), seen, passed }
    }

    /// The items of one component, searched breadth first from its first point, then those of its rings.
    fn component(&mut self, number: usize, group: &[usize]) {
        let root = group[0];
        self.seen[root] = true;
        let first = self.point(root, None, number);
        let mut queue = VecDeque::from([(root, first)]);
        while let Some((point, before)) = queue.pop_front() {
            for incidence in self.lines_by_angle(point) {
                if std::mem::replace(&mut self.passed[incidence.line], true) {
                    continue;
                }
                let mut last = self.path(incidence, before, number);
                let far = self.network.far(incidence);
                if !std::mem::replace(&mut self.seen[far], true) {
                    last = self.point(far, last, number);
                    queue.push_back((far, last));
                }
            }
        }
        for (ring, &[a, b]) in self.network.features().rings.iter().enumerate() {
            let (a, b) = (a as usize, b as usize);
            // A gap between two components belongs to the later one.
            let ours = |point: usize| group.contains(&point);
            if (ours(a) || ours(b)) && self.seen[a] && self.seen[b] {
                let (centre, arms) = self.network.arms_of_ring(ring, radius(self.patch));
                let place = Place::Ring(ring);
                let parent = (0..self.items.len()).rev().find(|&i| self.items[i].component == Some(number));
                self.push(Item {
                    kind: ItemKind::Ring,
                    centre,
                    arms,
                    place,
                    parent,
                    component: Some(number),
                });
            }
        }
    }

    fn push(&mut self, item: Item) -> usize {
        self.items.push(item);
        self.items.len() - 1
    }

    /// The lines at a point by the angle at which they leave it.
    fn lines_by_angle(&self, point: usize) -> Vec<Incidence> {
        let centre = self.network.place(point);
        let reach = radius(self.patch);
        let angle = |incidence: &Incidence| {
            let length = self.network.length(incidence.line);
            let along = if incidence.starts { reach.min(length) } else { (length - reach).max(0.0) };
            let [row, col] = self.network.at(incidence.line, along);
            let angle = libm::atan2(row - centre[0], col - centre[1]);
            if angle < 0.0 { angle + std::f64::consts::TAU } else { angle }
        };
        let mut lines = self.network.incidences(point).to_vec();
        lines.sort_by(|a, b| angle(a).total_cmp(&angle(b)).then(a.line.cmp(&b.line)));
        lines
    }

    /// The item of a point, unless a ring closes there; the number of the item that comes before what follows.
    fn point(&mut self, point: usize, parent: Option<usize>, component: usize) -> Option<usize> {
        if self.network.partner(point).is_some() {
            return parent;
        }
        let arms = self.network.arms(point, radius(self.patch));
        let kind = match arms.len() {
            0 | 1 => ItemKind::End,
            2 => ItemKind::Path,
            _ => ItemKind::Branch,
        };
        let (centre, place) = (self.network.place(point), Place::Point(point));
        Some(self.push(Item { kind, centre, arms, place, parent, component: Some(component) }))
    }

    /// The items along a line, from the end at hand to the other.
    fn path(&mut self, incidence: Incidence, before: Option<usize>, component: usize) -> Option<usize> {
        let line = incidence.line;
        let length = self.network.length(line);
        let n = ((length / (self.patch / 2.0)).ceil() as usize).saturating_sub(1);
        let mut last = before;
        for j in 1..=n {
            let j = if incidence.starts { j } else { n + 1 - j };
            let along = j as f64 * length / (n + 1) as f64;
            let centre = self.network.at(line, along);
            let arms = self.network.arms_along(line, along, radius(self.patch));
            let place = Place::Line(line, along);
            let kind = ItemKind::Path;
            last =
                Some(self.push(Item { kind, centre, arms, place, parent: last, component: Some(component) }));
        }
        last
    }
}

use orograph_core::{key, unit};

use super::*;

struct Case {
    cols: usize,
    right: Vec<u32>,
    down: Vec<u32>,
    pins: Vec<Pin>,
}

impl Case {
    fn random(rows: usize, cols: usize, seed: u64, most: u32, pinned: f64) -> Self {
        let n = rows * cols;
        let draw = |stream: u64, i: usize| unit(key(seed, stream, i as i64, 0));
        let capacity = |stream: u64, i: usize| (draw(stream, i) * f64::from(most)) as u32;
        let pin = |i: usize| match draw(3, i) {
            u if u < pinned / 2.0 => Pin::Source,
            u if u < pinned => Pin::Sink,
            _ => Pin::Free,
        };
        let mut pins: Vec<Pin> = (0..n).map(pin).collect();
        (pins[0], pins[n - 1]) = (Pin::Source, Pin::Sink);
        Self {
            cols,
            right: (0..n).map(|i| capacity(1, i)).collect(),
            down: (0..n).map(|i| capacity(2, i)).collect(),
            pins,
        }
    }

    fn cut(&self) -> MinCut {
        let network = Network { cols: self.cols, right: &self.right, down: &self.down, pins: &self.pins };
        min_cut(&network, &Job::detached()).unwrap()
    }

    fn edges(&self) -> Vec<(usize, usize, u32)> {
        let n = self.pins.len();
        let across = (0..n).filter(|i| (i + 1) % self.cols != 0).map(|i| (i, i + 1, self.right[i]));
        let down = (0..n - self.cols).map(|i| (i, i + self.cols, self.down[i]));
        across.chain(down).collect()
    }

    fn value(&self, side: impl Fn(usize) -> bool) -> u64 {
        self.edges().into_iter().filter(|&(a, b, _)| side(a) != side(b)).map(|(_, _, c)| u64::from(c)).sum()
    }

    fn honours(&self, side: impl Fn(usize) -> bool) -> bool {
        self.pins.iter().enumerate().all(|(i, pin)| match pin {
            Pin::Free => true,
            Pin::Source => side(i),
            Pin::Sink => !side(i),
        })
    }
}

#[test]
fn small_cuts_are_the_least_and_the_smallest_of_all_partitions() {
    for seed in 0..200 {
        let case = Case::random(3, 4, seed, 5, 0.2);
        let found = case.cut();
        let (mut least, mut common) = (u64::MAX, 0_u32);
        for bits in 0..1_u32 << 12 {
            let side = |i: usize| bits >> i & 1 == 1;
            if !case.honours(side) {
                continue;
            }
            let value = case.value(side);
            if value < least {
                (least, common) = (value, bits);
            } else if value == least {
                common &= bits;
            }
        }
        assert_eq!(found.flow, least, "seed {seed}");
        let bits =
            found.source_side.iter().enumerate().fold(0, |bits, (i, &side)| bits | u32::from(side) << i);
        assert_eq!(bits, common, "seed {seed}");
    }
}

/// The same by breadth-first augmenting paths over an edge list: slow and plain.
fn plain_cut(case: &Case) -> MinCut {
    let n = case.pins.len();
    let mut rest = vec![std::collections::BTreeMap::new(); n + 2];
    for (a, b, capacity) in case.edges() {
        *rest[a].entry(b).or_insert(0_u64) += u64::from(capacity);
        *rest[b].entry(a).or_insert(0) += u64::from(capacity);
    }
    for (i, pin) in case.pins.iter().enumerate() {
        match pin {
            Pin::Source => _ = rest[n].insert(i, u64::from(u32::MAX) * 1000),
            Pin::Sink => _ = rest[i].insert(n + 1, u64::from(u32::MAX) * 1000),
            Pin::Free => {}
        }
    }
    let mut flow = 0;
    loop {
        let mut from = vec![usize::MAX; n + 2];
        from[n] = n;
        let mut queue = VecDeque::from([n]);
        while let Some(i) = queue.pop_front() {
            for (&j, &rest) in &rest[i] {
                if rest > 0 && from[j] == usize::MAX {
                    from[j] = i;
                    queue.push_back(j);
                }
            }
        }
        if from[n + 1] == usize::MAX {
            let source_side = (0..n).map(|i| from[i] != usize::MAX).collect();
            return MinCut { source_side, flow };
        }
        let (mut i, mut most) = (n + 1, u64::MAX);
        while i != n {
            most = most.min(rest[from[i]][&i]);
            i = from[i];
        }
        let mut i = n + 1;
        while i != n {
            *rest[from[i]].get_mut(&i).unwrap() -= most;
            *rest[i].entry(from[i]).or_insert(0) += most;
            i = from[i];
        }
        flow += most;
    }
}

#[test]
fn larger_cuts_equal_those_of_plain_augmenting_paths() {
    for seed in 0..60 {
        let (rows, cols) = (2 + seed as usize % 13, 2 + seed as usize * 7 % 17);
        let case = Case::random(rows, cols, seed, [4, 1000, 60_000][seed as usize % 3], 0.08);
        assert_eq!(case.cut(), plain_cut(&case), "seed {seed}");
    }
}

#[test]
fn no_terminal_or_no_cell_is_no_cut() {
    let empty = Case { cols: 0, right: vec![], down: vec![], pins: vec![] };
    assert_eq!(empty.cut().flow, 0);
    let free = Case { cols: 2, right: vec![9; 4], down: vec![9; 4], pins: vec![Pin::Free; 4] };
    assert_eq!(free.cut(), MinCut { source_side: vec![false; 4], flow: 0 });
    let one = Case { pins: vec![Pin::Free, Pin::Source, Pin::Free, Pin::Free], ..free };
    assert_eq!(one.cut(), MinCut { source_side: vec![true; 4], flow: 0 });
}

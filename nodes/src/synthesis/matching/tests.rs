//! Choices between few candidates of which it is known what should become of them.

use orograph_core::{FeatureKind, Heightfield, Job};

use super::*;
use crate::synthesis::{
    cut::SeamWeight,
    network::Arm,
    settings::{Preset, UserTerms},
};
use crate::test_fields::field;

const PATCH: usize = 64;

fn rules() -> Rules {
    Rules { variety: 1, ..Rules::of(Preset::Default, PATCH) }
}

/// A place with straight lines at these angles, in degrees from the columns' direction towards the rows'.
fn star(center: Point, angles: &[f64]) -> Site {
    let radius = rules().radius();
    let arm = |angle: &f64| {
        let (sin, cos) = libm::sincos(angle.to_radians());
        let at = |by: f64| [center[0] + by * sin, center[1] + by * cos];
        Arm { track: vec![at(0.0), at(radius / 2.0), at(radius)] }
    };
    let role = match angles.len() {
        1 => Role::End,
        2 => Role::Path,
        _ => Role::Branch,
    };
    let mut arms: Vec<Arm> = angles.iter().map(arm).collect();
    if role == Role::Branch {
        arms.sort_by(|a, b| a.angle().total_cmp(&b.angle()));
    }
    Site { role, center, arms }
}

fn candidates(sites: Vec<Site>) -> Vec<Candidate> {
    sites.into_iter().map(|site| Candidate { exemplar: 0, site, mirrored: false }).collect()
}

/// Asks `ask` about a scene with this exemplar, rules, wanted heights and ground.
fn with_scene<T>(
    terrain: &Heightfield,
    rules: &Rules,
    wanted: &[(usize, f64)],
    ground: Option<&Heightfield>,
    ask: impl Fn(&Scene<'_>) -> T,
) -> T {
    let job = Job::detached();
    let exemplars = [Exemplar::new(terrain, &job).unwrap()];
    let mut canvas = Canvas::new((100, 100), &job).unwrap();
    if let Some(ground) = ground {
        canvas.lay(ground);
    }
    let wanted = Wanted::new(wanted.to_vec()).unwrap();
    let (uses, kind) = (Uses::default(), FeatureKind::Ridge);
    ask(&Scene { canvas: &canvas, exemplars: &exemplars, kind, uses: &uses, wanted: &wanted, rules })
}

fn chosen(site: &Site, pool: &Pool, scene: &Scene<'_>, chance: f64) -> Option<Choice> {
    choose(site, pool, scene, chance, &Job::detached()).unwrap()
}

fn rough() -> Heightfield {
    field(400, 400, |row, col| 300.0 + 40.0 * libm::sin(row as f64 / 9.0) * libm::cos(col as f64 / 7.0))
}

#[test]
fn a_place_without_a_candidate_of_its_degree_is_served_by_the_nearest_degree() {
    let terrain = rough();
    let middle = [50.0, 50.0];
    let [two, three, four, five] = [
        &[0.0, 180.0][..],
        &[0.0, 100.0, 220.0],
        &[0.0, 90.0, 180.0, 270.0],
        &[0.0, 70.0, 140.0, 220.0, 290.0],
    ];
    let at = [200.0, 200.0];
    let one = candidates(vec![star(at, &[10.0])]);
    let branches = |angles: &[f64]| Pool { branches: candidates(vec![star(at, angles)]), ..Pool::default() };
    let paths = || Pool { paths: candidates(vec![star(at, two)]), ..Pool::default() };
    let ends = || Pool { ends: one.clone(), ..Pool::default() };
    // With a line more it may have to be turned on, with none left out it is just the same.
    let cases: [(&[f64], Pool, Option<Fallback>, usize); 8] = [
        (three, branches(three), Some(Fallback::None), 3),
        (three, branches(four), Some(Fallback::ArmIgnored), 3),
        (four, branches(three), Some(Fallback::ArmUnmatched), 3),
        (&[45.0], paths(), Some(Fallback::ArmIgnored), 1),
        (two, branches(three), Some(Fallback::ArmIgnored), 2),
        (two, ends(), Some(Fallback::ArmUnmatched), 1),
        (three, paths(), None, 0),
        (three, branches(five), None, 0),
    ];
    for (angles, pool, expected, n_arms) in cases {
        let choice = with_scene(&terrain, &rules(), &[], None, |scene| {
            chosen(&star(middle, angles), &pool, scene, 0.0)
        });
        assert_eq!(choice.as_ref().map(|choice| choice.fallback), expected, "{angles:?}");
        if let Some(Choice { piece, .. }) = choice {
            // The centre; of each line its end and a point half-way; of less than three lines anchors beside them.
            let anchors = [0, 3, 2].get(n_arms).copied().unwrap_or(0);
            assert_eq!(piece.patch.controls.len(), 1 + 2 * n_arms + anchors, "{angles:?}");
        }
    }
}

#[test]
fn a_split_branch_keeps_all_of_its_lines() {
    for angles in [&[0.0, 100.0, 220.0][..], &[5.0, 95.0, 180.0, 270.0], &[0.0, 70.0, 140.0, 220.0, 290.0]] {
        let site = star([50.0, 50.0], angles);
        let paths = split(&site);
        for path in &paths {
            assert_eq!((path.role, path.arms.len(), path.center), (Role::Path, 2, site.center));
        }
        for arm in &site.arms {
            assert!(paths.iter().any(|path| path.arms.contains(arm)), "{angles:?}");
        }
        // One for the way through, one for each other line at most.
        assert!(paths.len() < angles.len());
    }
    let of_three = split(&star([50.0, 50.0], &[0.0, 100.0, 190.0]));
    let ends = |path: &Site| [0, 1].map(|arm| path.arms[arm].angle().to_degrees().rem_euclid(360.0).round());
    // The straightest way is that of 170 degrees; the line at 100 goes on along that at 0, 100 degrees off, not at 190.
    let mut way = ends(&of_three[0]);
    way.sort_by(f64::total_cmp);
    assert_eq!(way, [0.0, 190.0]);
    assert!(ends(&of_three[1]).contains(&100.0) && ends(&of_three[1]).contains(&0.0));
    assert!(split(&star([50.0, 50.0], &[0.0])).is_empty());
}

#[test]
fn chance_draws_among_those_that_were_ranked() {
    let terrain = rough();
    let sites =
        (0..12).map(|i| star([150.0 + 8.0 * f64::from(i), 200.0], &[0.0, 160.0 + f64::from(i)])).collect();
    let pool = Pool { paths: candidates(sites), ..Pool::default() };
    let site = star([50.0, 50.0], &[0.0, 160.0]);
    // By heights alone costs lie close enough for chance to have a say.
    let rules = Rules { variety: 4, seam_weight: SeamWeight::Plain, ..rules() };
    let mut drawn: Vec<[u64; 2]> = Vec::new();
    with_scene(&terrain, &rules, &[], Some(&field(100, 100, |_, _| 290.0)), |scene| {
        let mut sources = Vec::new();
        for k in 0..24 {
            let choice = chosen(&site, &pool, scene, f64::from(k) / 24.0).unwrap();
            let best = choice.considered.iter().map(|ranked| ranked.cost).fold(f64::INFINITY, f64::min);
            let taken = choice.piece.patch.source_center;
            let taken = choice.considered.iter().find(|ranked| ranked.center == taken).unwrap();
            assert!(taken.cost == choice.cost && taken.cost <= 1.2 * best);
            sources.push(taken.center.map(f64::to_bits));
        }
        sources
    })
    .into_iter()
    .for_each(|source| {
        if !drawn.contains(&source) {
            drawn.push(source);
        }
    });
    assert!((2..=4).contains(&drawn.len()), "{drawn:?}");
}

#[test]
fn ground_of_the_wanted_height_is_taken_and_lifted_to_meet_it() {
    // Two like ridges, 500 m and 900 m high.
    let terrain = field(200, 400, |row, col| {
        let crest = if col < 200 { 500.0 } else { 900.0 };
        crest - 2.0 * (row as f64 - 100.0).abs()
    });
    let sites = vec![star([100.0, 100.0], &[0.0, 180.0]), star([100.0, 300.0], &[0.0, 180.0])];
    let pool = Pool { paths: candidates(sites), ..Pool::default() };
    let site = star([50.0, 50.0], &[0.0, 180.0]);
    for (height, source) in [(470.0, 100.0), (880.0, 300.0), (1500.0, 300.0), (-100.0, 100.0)] {
        let wanted = [(50 * 100 + 50, height)];
        let choice =
            with_scene(&terrain, &rules(), &wanted, None, |scene| chosen(&site, &pool, scene, 0.0)).unwrap();
        let Piece { sheet, patch, .. } = choice.piece;
        assert_eq!(patch.source_center[1], source);
        let at = (0..sheet.window.len()).find(|&i| sheet.window.cell(i) == (50, 50)).unwrap();
        assert!((f64::from(sheet.heights[at]) - height).abs() < 1e-3, "{}", sheet.heights[at]);
        // A height that is wanted farther off than a quarter of a patch is another place's business.
        let far = with_scene(&terrain, &rules(), &[(50 * 100 + 70, height)], None, |scene| {
            chosen(&site, &pool, scene, 0.0)
        });
        assert_eq!(far.unwrap().piece.patch.offset, 0.0);
    }
}

#[test]
fn lines_that_bend_at_a_join_cost_one_less_the_cosine() {
    let terrain = rough();
    let ground = field(100, 100, |_, _| 300.0);
    let site = star([50.0, 50.0], &[0.0, 180.0]);
    let rules = rules();
    let basis = Basis::new(&controls(&site, &[0, 1], &rules), rules.radius()).unwrap();
    for degrees in [0.0_f64, 10.0, 25.0, 40.0] {
        // A line that crosses the join, a quarter of a patch from the centre, at an angle.
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let across = |by: f64| [50.0 + by * sin, 50.0 + PATCH as f64 / 4.0 + by * cos];
        let mut bent = site.clone();
        bent.arms[0].track = vec![[50.0, 50.0], across(-8.0), across(8.0), site.arms[0].tip()];
        let spline = basis.fit(&controls(&site, &[0, 1], &rules)).unwrap();
        let candidate = Candidate { exemplar: 0, site: bent, mirrored: false };
        let fit = Fit { candidate: &candidate, arms: vec![0, 1], sources: Vec::new(), spline, bend: 0.0 };
        let turns = with_scene(&terrain, &rules, &[], Some(&ground), |scene| {
            Probes::new(&site, &basis, &Pool::default(), scene).turns(&fit, &basis)
        });
        assert!((turns - (1.0 - cos)).abs() < 1e-6, "{degrees}: {turns}");
    }
    // A line that was turned as a whole does not bend, nor does anything where nothing is joined.
    let turned = star([200.0, 200.0], &[40.0, 220.0]);
    let spline = basis.fit(&controls(&turned, &[0, 1], &rules)).unwrap();
    let candidate = Candidate { exemplar: 0, site: turned, mirrored: false };
    let fit = Fit { candidate: &candidate, arms: vec![0, 1], sources: Vec::new(), spline, bend: 0.0 };
    for ground in [Some(&ground), None] {
        let turns = with_scene(&terrain, &rules, &[], ground, |scene| {
            Probes::new(&site, &basis, &Pool::default(), scene).turns(&fit, &basis)
        });
        assert!(turns.abs() < 1e-9, "{turns}");
    }
}

#[test]
fn a_patch_that_makes_a_pit_is_passed_over_if_pits_cost() {
    // Two like ridges, the first with a crater beside it.
    let terrain = field(200, 400, |row, col| {
        let crater = libm::hypot(row as f64 - 116.0, col as f64 - 100.0) < 6.0;
        500.0 - 2.0 * (row as f64 - 100.0).abs() - if crater { 30.0 } else { 0.0 }
    });
    let sites = vec![star([100.0, 100.0], &[0.0, 180.0]), star([100.0, 300.0], &[0.0, 180.0])];
    let pool = Pool { paths: candidates(sites), ..Pool::default() };
    let site = star([50.0, 50.0], &[0.0, 180.0]);
    for (pits, source) in [(0.0, 100.0), (1.0, 300.0)] {
        let rules = Rules { terms: UserTerms { pits, ..UserTerms::default() }, ..rules() };
        let choice =
            with_scene(&terrain, &rules, &[], None, |scene| chosen(&site, &pool, scene, 0.0)).unwrap();
        assert_eq!(choice.piece.patch.source_center[1], source);
    }
}

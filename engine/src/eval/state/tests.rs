use orograph_core::{NodeType, ParamValue, Value, prelude::*};

use super::*;
use crate::{
    Cache, Evaluator, GraphBuilder,
    cache::StoredOutput,
    eval::{CancelToken, Request, Silent},
    graph::{Graph, NodeId, OutputRef},
};

/// A field of one height, too large to lie within a record.
#[derive(Params)]
struct Field {
    /// The height.
    #[param(default = 0, range = -1e5..=1e5, unit = "m")]
    height: f64,
}

/// A field.
#[derive(Outputs)]
struct FieldOut {
    /// The field.
    terrain: Heightfield,
}

impl Node for Field {
    const ID: &'static str = "test.field";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = FieldOut;
    fn run(&self, (): (), job: &Job) -> Result<FieldOut> {
        let grid = Grid::new(32, 32, CellSize::square(1.0))?;
        Ok(FieldOut { terrain: Heightfield::filled(grid, self.height as f32, job)? })
    }
}

/// Counts fields.
#[derive(Params)]
struct Count {}

/// Fields to count.
#[derive(Inputs)]
struct CountIn<'a> {
    /// The fields.
    terrains: Vec<&'a Heightfield>,
}

/// A number.
#[derive(Outputs)]
struct CountOut {
    /// How many.
    number: f64,
}

impl Node for Count {
    const ID: &'static str = "test.count";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = CountIn<'a>;
    type Outputs = CountOut;
    fn run(&self, inputs: CountIn<'_>, _: &Job) -> Result<CountOut> {
        Ok(CountOut { number: inputs.terrains.len() as f64 })
    }
}

/// `lost` and `slow` are counted by `both`, `lost` alone by `one`.
fn graph() -> (Arc<Graph>, [NodeId; 4]) {
    let mut builder = GraphBuilder::new();
    let (field, count) = (Arc::new(NodeType::of::<Field>()), Arc::new(NodeType::of::<Count>()));
    let mut fields = ["lost", "slow"]
        .iter()
        .zip([1.0, 2.0])
        .map(|(name, height)| builder.add(name, &field, vec![ParamValue::Number(height)]).expect("a node"));
    let (lost, slow) = (fields.next().expect("two"), fields.next().expect("two"));
    let [both, one] = ["both", "one"].map(|name| builder.add(name, &count, Vec::new()).expect("a node"));
    for (from, to) in [(lost, both), (slow, both), (lost, one)] {
        builder.connect(from, "terrain", to, "terrains").expect("a wire");
    }
    (Arc::new(builder.build().expect("a graph")), [lost, slow, both, one])
}

/// What a field's computation leaves; its value in the cache where `held` says so.
fn record(height: f32, held: Option<&Cache>) -> Arc<Record> {
    let grid = Grid::new(32, 32, CellSize::square(1.0)).expect("a grid");
    let terrain = Heightfield::filled(grid, height, &Job::detached()).expect("a field");
    let value = Value::Heightfield(Arc::new(terrain));
    let output = StoredOutput::of(&value);
    assert!(output.inline.is_none(), "a value that can be lost");
    if let Some(cache) = held {
        cache.hold(&output, value, 1);
    }
    Arc::new(Record { outputs: vec![output], ..Record::default() })
}

/// Takes a node that can run from the list, as a worker does.
fn take(state: &mut State, node: u32) {
    let before = state.ready.len();
    state.ready.retain(|&ready| ready != node);
    assert_eq!(state.ready.len() + 1, before, "node {node} was ready");
    state.lines[node as usize].phase = Phase::Running;
}

/// A node waits for two inputs. One of them was known when it asked; before the other comes, someone else finds that the value
/// of the first is lost, and has it made again. The node must wait for that, not fail for want of a record.
#[test]
fn a_node_waits_for_an_input_that_is_made_again_for_someone_else() {
    let evaluator = Evaluator::new(Cache::new(1 << 20, None), 1).expect("threads");
    let (graph, [lost, slow, both, one]) = graph();
    let outputs = [both, one].map(|node| OutputRef { node, output: 0 }).to_vec();
    let request = Request::values(graph, outputs);
    let run = Run::new(Arc::clone(&evaluator.shared), request, Arc::new(Silent), CancelToken::new());
    let [lost, slow, both, one] = [lost, slow, both, one].map(|node| node.0);
    let recipe = run.key(lost).recipe.expect("a key");
    evaluator.cache().remember(recipe, &record(1.0, None));

    let mut state = State::new(4);
    Scheduler::new(&run, &mut state).request(both, true);
    assert!(matches!(state.lines[lost as usize].phase, Phase::Done(_)), "its digest is known");
    assert!(matches!(state.lines[both as usize].phase, Phase::Records));
    take(&mut state, slow);
    Scheduler::new(&run, &mut state).request(one, true);
    take(&mut state, lost);
    Scheduler::new(&run, &mut state).complete(slow, record(2.0, Some(evaluator.cache())), 1);
    assert!(
        matches!(state.lines[both as usize].phase, Phase::Records),
        "{:?}",
        state.lines[both as usize].outcome
    );
    Scheduler::new(&run, &mut state).complete(lost, record(1.0, Some(evaluator.cache())), 1);
    take(&mut state, one);
    take(&mut state, both);
    assert!(state.ready.is_empty());
    assert!(state.lines.iter().all(|line| !matches!(line.phase, Phase::Failed)));
}

/// What is queued counts as wanted by its run, and by it no more once it is dropped.
#[test]
fn queued_nodes_are_wanted_until_they_are_dropped() {
    let evaluator = Evaluator::new(Cache::new(1 << 20, None), 1).expect("threads");
    let (graph, [lost, _, _, one]) = graph();
    let run = || {
        let request = Request::values(Arc::clone(&graph), vec![OutputRef { node: one, output: 0 }]);
        Run::new(Arc::clone(&evaluator.shared), request, Arc::new(Silent), CancelToken::new())
    };
    let (first, second) = (run(), run());
    let (in_flight, lost) = (&evaluator.shared.in_flight, lost.0);
    let (mut of_first, mut of_second) = (State::new(4), State::new(4));
    Scheduler::new(&first, &mut of_first).request(lost, true);
    Scheduler::new(&second, &mut of_second).request(lost, true);
    let action = of_first.lines[lost as usize].action.expect("a key");
    assert!(in_flight.claim(action, &Arc::downgrade(&first), lost, &first.cancel));
    take(&mut of_first, lost);
    assert!(first.goes_on_for_others(lost, &action), "the second run's worker has not come to it yet");
    assert!(!in_flight.claim(action, &Arc::downgrade(&second), lost, &second.cancel));
    second.cancel.cancel();
    assert!(!first.goes_on_for_others(lost, &action));
    assert_eq!(in_flight.release(&action).len(), 1, "it is told all the same");

    Scheduler::new(&first, &mut of_first).retry(lost, Phase::Values);
    assert!(!in_flight.is_empty());
    Scheduler::new(&first, &mut of_first).drop_ready();
    assert!(in_flight.is_empty(), "nothing is left behind");
}

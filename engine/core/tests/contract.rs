//! One declaration, read back as a spec: what the derives write.

use orograph_core::prelude::*;
use orograph_core::{Arity, NodeSpec, NodeType, ParamKind, ParamValue, Slot, Unit, ValueType};

/// Which way to round.
#[derive(Choice, Clone, Copy, Debug, PartialEq)]
pub enum Rounding {
    /// To the nearest.
    Nearest,
    /// Towards minus infinity.
    RoundDown,
}

/// Rounds heights to whole steps. Voids stay voids.
///
/// A second paragraph.
#[derive(Params, Clone, Debug)]
pub struct Quantise {
    /// Height of a step.
    #[param(default = 1, range = 0.01..=1000.0, slider = 0.1..=10.0, unit = "m")]
    pub step: f64,
    /// How to round.
    #[param(default = Rounding::Nearest)]
    pub rounding: Rounding,
    /// How often.
    #[param(default = 1u32, range = 1..=9, unit = "1")]
    pub rounds: u32,
    /// Spare.
    #[param(default = false)]
    pub spare: bool,
    /// A name.
    #[param(default = "x.tif")]
    pub file: OutputPath,
    /// A curve.
    #[param(default = [[0.0, 0.0], [1.0, 1.0]])]
    pub curve: Curve,
}

/// Inputs of [`Quantise`].
#[derive(Inputs)]
pub struct QuantiseIn<'a> {
    /// Terrain to round.
    pub terrain: &'a Heightfield,
    /// Where to round.
    pub mask: Option<&'a Mask>,
    /// More.
    pub more: Vec<&'a Table>,
}

/// Outputs of [`Quantise`].
#[derive(Outputs)]
pub struct QuantiseOut {
    /// Rounded terrain.
    pub terrain: Heightfield,
}

impl Node for Quantise {
    const ID: &'static str = "test.quantise";
    const VERSION: u32 = 3;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = QuantiseIn<'a>;
    type Outputs = QuantiseOut;

    fn run(&self, inputs: QuantiseIn<'_>, job: &Job) -> Result<QuantiseOut> {
        let terrain =
            inputs.terrain.map(job, |height| ((f64::from(height) / self.step).round() * self.step) as f32)?;
        Ok(QuantiseOut { terrain })
    }
}

fn spec() -> NodeSpec {
    NodeType::of::<Quantise>().spec().clone()
}

#[test]
fn a_declaration_becomes_a_spec() {
    let spec = spec();
    assert_eq!(spec.summary(), "Rounds heights to whole steps.");
    let arities: Vec<_> = spec.inputs.iter().map(|port| (port.value_type, port.arity)).collect();
    let expected = [
        (ValueType::Heightfield, Arity::One),
        (ValueType::Mask, Arity::Optional),
        (ValueType::Table, Arity::Many),
    ];
    assert_eq!(arities, expected);
    assert_eq!(spec.params[0].kind, ParamKind::Number { range: (0.01, 1000.0), slider: (0.1, 10.0) });
    assert_eq!(spec.params[0].unit, Unit::Metre);
    assert_eq!(spec.params[0].default, ParamValue::Number(1.0));
    assert_eq!(spec.params[1].default, ParamValue::Text("nearest".into()));
    assert!(matches!(&spec.params[1].kind, ParamKind::Choice { options } if options[1].name == "round_down"));
    assert_eq!(spec.params[2].kind, ParamKind::Integer { range: (1, 9), slider: (1, 9) });
}

#[test]
fn a_spec_crosses_as_ron_text() {
    let spec = spec();
    let text = ron::to_string(&spec).unwrap();
    assert_eq!(ron::from_str::<NodeSpec>(&text).unwrap(), spec);
}

#[test]
fn hard_ranges_hold_before_run_and_settings_round_trip() {
    let node = NodeType::of::<Quantise>();
    let defaults = Quantise::default().to_values();
    assert_eq!(Quantise::from_values(&defaults).unwrap().to_values(), defaults);
    for (index, bad) in [
        (0, ParamValue::Number(0.0)),
        (0, ParamValue::Number(f64::NAN)),
        (0, ParamValue::Integer(1)),
        (1, ParamValue::Text("up".into())),
        (2, ParamValue::Integer(10)),
        (4, ParamValue::Text("../x.tif".into())),
        (5, ParamValue::Curve(vec![[0.5, 0.0], [0.5, 1.0]])),
    ] {
        let mut values = defaults.clone();
        values[index] = bad;
        assert!(node.instantiate(&values).is_err(), "{values:?}");
    }
    assert!(node.instantiate(&defaults).is_ok());
}

#[test]
fn a_node_runs_through_its_erased_form() {
    let node = NodeType::of::<Quantise>().instantiate(&Quantise::default().to_values()).unwrap();
    let grid = Grid::new(1, 2, CellSize::square(1.0)).unwrap();
    let field = Heightfield::new(grid, vec![1.4, 2.6]).unwrap();
    let slots = [Slot::One(Value::Heightfield(field.into())), Slot::Empty, Slot::Empty];
    let out = node.run(&slots, &Job::detached()).unwrap();
    assert!(matches!(&out[0], Value::Heightfield(field) if field.cells() == [1.0, 3.0]));
    let wrong = [Slot::One(Value::Number(1.0)), Slot::Empty, Slot::Empty];
    assert!(matches!(node.run(&wrong, &Job::detached()), Err(Error::InputType { .. })));
}

/// Where to round, shared by several nodes.
#[derive(Params, Clone, Debug, PartialEq)]
pub struct Window {
    /// Lowest height.
    #[param(default = 0, range = -10.0..=10.0, unit = "m")]
    pub lowest: f64,
    /// Highest height.
    #[param(default = 1, range = -10.0..=10.0, unit = "m")]
    pub highest: f64,
}

/// Has shared settings between its own.
#[derive(Params, Clone, Debug, PartialEq)]
pub struct Sharing {
    /// Before.
    #[param(default = false)]
    pub before: bool,
    /// As it comes.
    #[param(flatten)]
    pub window: Window,
    /// After.
    #[param(default = 3u32, range = 1..=9, unit = "1")]
    pub after: u32,
}

/// Shares what shares, with other defaults.
#[derive(Params, Clone, Debug, PartialEq)]
pub struct Nested {
    /// All of it.
    #[param(flatten, default = Sharing { after: 5, ..Sharing::default() })]
    pub sharing: Sharing,
    /// Last.
    #[param(default = true)]
    pub last: bool,
}

#[test]
fn flattened_settings_stand_in_place_under_their_own_names() {
    let names = |specs: Vec<orograph_core::ParamSpec>| -> Vec<String> {
        specs.into_iter().map(|spec| spec.name.into()).collect()
    };
    assert_eq!(names(Sharing::specs()), ["before", "lowest", "highest", "after"]);
    assert_eq!(names(Nested::specs()), ["before", "lowest", "highest", "after", "last"]);
    assert_eq!((Sharing::COUNT, Nested::COUNT), (4, 5));
    assert_eq!(Sharing::specs()[3].default, ParamValue::Integer(3));
    assert_eq!(Nested::specs()[3].default, ParamValue::Integer(5));
    assert_eq!(Nested::specs()[1], Window::specs()[0]);
}

#[test]
fn flattened_settings_round_trip() {
    let window = Window { lowest: -2.0, highest: 7.0 };
    let nested = Nested { sharing: Sharing { before: true, window, after: 9 }, last: false };
    let values = nested.to_values();
    let expected = [
        ParamValue::Boolean(true),
        ParamValue::Number(-2.0),
        ParamValue::Number(7.0),
        ParamValue::Integer(9),
        ParamValue::Boolean(false),
    ];
    assert_eq!(values, expected);
    assert_eq!(Nested::from_values(&values), Ok(nested));
    assert!(matches!(Nested::from_values(&values[1..]), Err(Error::ParamCount { expected: 5, found: 4 })));
    let mut wrong = values;
    wrong[2] = ParamValue::Boolean(true);
    assert!(matches!(Nested::from_values(&wrong), Err(Error::ParamType { name }) if name == "highest"));
}

//! Arithmetic: one heightfield and another, or a number, cell by cell.
use orograph_core::prelude::*;

/// What to do with the two heights of a cell.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// The sum.
    Add,
    /// The first less the second.
    Subtract,
    /// The product; the second's metres count as a pure number.
    Multiply,
    /// The quotient; the second's metres count as a pure number, and a division by 0 gives a void.
    Divide,
    /// The lower of the two.
    Minimum,
    /// The higher of the two.
    Maximum,
    /// How far the two lie apart, never below 0.
    Difference,
}

/// Adds, subtracts, multiplies or compares two terrains, or a terrain and a number.
///
/// A cell is a void where either terrain has one. The result lies where the first terrain lies. To mix two
/// terrains, or to keep an operation to a mask, use `combine.blend`.
#[derive(Params, Clone, Debug)]
pub struct Arithmetic {
    /// What to do with the two heights of a cell.
    #[param(default = Operation::Add)]
    pub operation: Operation,
    /// The second operand where no second terrain is connected; metres, or a pure factor.
    #[param(default = 0, range = -100_000.0..=100_000.0, slider = -1000.0..=1000.0, unit = "m")]
    pub value: f64,
}

/// Inputs of [`Arithmetic`].
#[derive(Inputs)]
pub struct ArithmeticIn<'a> {
    /// First operand.
    pub a: &'a Heightfield,
    /// Second operand, on a grid of the same size; the number when unconnected.
    pub b: Option<&'a Heightfield>,
}

/// Outputs of [`Arithmetic`].
#[derive(Outputs)]
pub struct ArithmeticOut {
    /// The result, on the first operand's grid.
    pub terrain: Heightfield,
}

impl Node for Arithmetic {
    const ID: &'static str = "combine.arithmetic";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = ArithmeticIn<'a>;
    type Outputs = ArithmeticOut;

    fn run(&self, inputs: ArithmeticIn<'_>, job: &Job) -> Result<ArithmeticOut> {
        let with = Operands { inputs, value: self.value as f32, job };
        // One loop an operation: a choice within the loop would keep it out of the wide registers.
        let terrain = match self.operation {
            Operation::Add => with.each(|a, b| a + b),
            Operation::Subtract => with.each(|a, b| a - b),
            Operation::Multiply => with.each(|a, b| a * b),
            Operation::Divide => with.each(|a, b| a / b),
            // `min` and `max` would pass over a void.
            Operation::Minimum => with.each(|a, b| if a.is_nan() || a < b { a } else { b }),
            Operation::Maximum => with.each(|a, b| if a.is_nan() || a > b { a } else { b }),
            Operation::Difference => with.each(|a, b| (a - b).abs()),
        }?;
        Ok(ArithmeticOut { terrain })
    }
}

struct Operands<'a> {
    inputs: ArithmeticIn<'a>,
    value: f32,
    job: &'a Job<'a>,
}

impl Operands<'_> {
    /// The operation on every cell; a void where either height is one or the result is not finite.
    fn each(&self, of: impl Fn(f32, f32) -> f32 + Sync) -> Result<Heightfield> {
        let finite = |a, b| {
            let result = of(a, b);
            if result.is_finite() { result } else { f32::NAN }
        };
        match self.inputs.b {
            Some(b) => self.inputs.a.map_with(b, self.job, finite),
            None => self.inputs.a.map(self.job, |a| finite(a, self.value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn each_operation_does_what_it_says() {
        let (a, b) = (row(&[6.0, -2.0]), row(&[2.0, 4.0]));
        for (operation, expected) in [
            (Operation::Add, [8.0, 2.0]),
            (Operation::Subtract, [4.0, -6.0]),
            (Operation::Multiply, [12.0, -8.0]),
            (Operation::Divide, [3.0, -0.5]),
            (Operation::Minimum, [2.0, -2.0]),
            (Operation::Maximum, [6.0, 4.0]),
            (Operation::Difference, [4.0, 6.0]),
        ] {
            let node = Arithmetic { operation, value: 0.0 };
            let out = node.run(ArithmeticIn { a: &a, b: Some(&b) }, &Job::detached()).unwrap();
            assert_eq!(out.terrain.cells(), expected, "{operation:?}");
            let single = row(&[2.0, 2.0]);
            let by_terrain = node.run(ArithmeticIn { a: &a, b: Some(&single) }, &Job::detached()).unwrap();
            let node = Arithmetic { operation, value: 2.0 };
            let by_number = node.run(ArithmeticIn { a: &a, b: None }, &Job::detached()).unwrap();
            assert_eq!(by_terrain.terrain.cells(), by_number.terrain.cells());
        }
    }

    #[test]
    fn voids_on_either_side_stay_voids_and_nothing_becomes_infinite() {
        let void = f32::NAN;
        for operation in [Operation::Add, Operation::Minimum, Operation::Maximum, Operation::Divide] {
            let node = Arithmetic { operation, value: 0.0 };
            let (a, b) = (row(&[void, 1.0, void]), row(&[1.0, void, void]));
            let out = node.run(ArithmeticIn { a: &a, b: Some(&b) }, &Job::detached()).unwrap();
            assert!(out.terrain.cells().iter().all(|cell| cell.is_nan()), "{operation:?}");
        }
        let by_nought = Arithmetic { operation: Operation::Divide, value: 0.0 };
        let out = by_nought.run(ArithmeticIn { a: &row(&[1.0]), b: None }, &Job::detached()).unwrap();
        assert!(out.terrain.cells()[0].is_nan());
        let (a, b) = (row(&[1.0]), row(&[1.0, 2.0]));
        let run = Arithmetic::default().run(ArithmeticIn { a: &a, b: Some(&b) }, &Job::detached());
        assert!(matches!(run, Err(Error::DimensionMismatch { .. })));
    }
}

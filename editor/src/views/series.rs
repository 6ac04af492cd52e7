//! What of a table is drawn in a plot: columns of numbers over another, in runs without gaps.

use orograph_core::{Cells, Column, Table};

/// Columns with numbers in them.
pub(super) fn number_columns(table: &Table) -> impl Iterator<Item = (&Column, &[f64])> {
    table.columns().iter().filter_map(|column| match &column.cells {
        Cells::Numbers(numbers) => Some((column, numbers.as_slice())),
        Cells::Texts(_) => None,
    })
}

/// What a plot is of.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Choice {
    /// Columns that are not drawn.
    pub(super) hidden: Vec<String>,
    /// Over the number of the row and not over the first column of numbers.
    pub(super) over_rows: bool,
    /// Logarithmic axes.
    pub(super) log: [bool; 2],
}

/// A column that is drawn.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Series {
    pub(super) name: String,
    pub(super) unit: &'static str,
    /// Places in the plot, of a logarithmic axis the logarithms; a number that is none ends a run.
    pub(super) runs: Vec<Vec<[f64; 2]>>,
}

/// The column that others are drawn over; none for the number of the row.
pub(super) fn base<'a>(table: &'a Table, choice: &Choice) -> Option<(&'a Column, &'a [f64])> {
    let several = number_columns(table).nth(1).is_some();
    number_columns(table).next().filter(|_| several && !choice.over_rows)
}

/// Columns that can be drawn.
pub(super) fn offered<'a>(table: &'a Table, choice: &Choice) -> Vec<&'a str> {
    let under = base(table, choice).map(|(column, _)| column.name.as_str());
    let columns = number_columns(table).map(|(column, _)| column.name.as_str());
    columns.filter(|name| Some(*name) != under).collect()
}

/// Columns that are better not drawn beside the others, for their numbers have other units: those without the unit
/// that most have, and of two that as many have, the later one, which is seldom a place along the axis.
pub(super) fn strangers(table: &Table, choice: &Choice) -> Vec<String> {
    let offered = offered(table, choice);
    let columns = || number_columns(table).filter(|(column, _)| offered.contains(&column.name.as_str()));
    let units: Vec<_> = columns().map(|(column, _)| column.unit.symbol()).collect();
    let count = |unit: &str| units.iter().filter(|other| **other == unit).count();
    let Some(most) = units.iter().max_by_key(|unit| count(unit)) else { return Vec::new() };
    let others = columns().filter(|(column, _)| column.unit.symbol() != *most);
    others.map(|(column, _)| column.name.clone()).collect()
}

/// The columns that are chosen, as they are drawn.
pub(super) fn series(table: &Table, choice: &Choice) -> Vec<Series> {
    let under = base(table, choice);
    let axis = |number: f64, axis: usize| match choice.log[axis] {
        true if number > 0.0 => libm::log10(number),
        true => f64::NAN,
        false => number,
    };
    let drawn = offered(table, choice);
    let drawn = drawn.iter().filter(|name| !choice.hidden.iter().any(|hidden| hidden == *name));
    let columns = drawn.filter_map(|name| number_columns(table).find(|(column, _)| column.name == **name));
    let draw = |(column, numbers): (&Column, &[f64])| {
        let mut runs: Vec<Vec<[f64; 2]>> = vec![Vec::new()];
        for (row, number) in numbers.iter().enumerate() {
            let x = under.map_or((row + 1) as f64, |(_, xs)| xs.get(row).copied().unwrap_or(f64::NAN));
            let place = [axis(x, 0), axis(*number, 1)];
            let known = place.iter().all(|number| number.is_finite());
            match runs.last_mut() {
                Some(run) if known => run.push(place),
                Some(run) if !run.is_empty() => runs.push(Vec::new()),
                _ => {}
            }
        }
        runs.retain(|run| !run.is_empty());
        Series { name: column.name.clone(), unit: column.unit.symbol(), runs }
    };
    columns.map(draw).collect()
}

/// A column's name and unit, as people read them.
pub(super) fn title(name: &str, unit: &str) -> String {
    let name = name.replace('_', " ");
    if unit == "1" || unit.is_empty() { name } else { format!("{name} ({unit})") }
}

/// What stands along the vertical axis: the one column, or the unit that all have.
pub(super) fn vertical_title<'a>(drawn: impl IntoIterator<Item = &'a Series>) -> String {
    let mut drawn = drawn.into_iter();
    let Some(first) = drawn.next() else { return String::new() };
    let mut rest = drawn.peekable();
    if rest.peek().is_none() {
        return title(&first.name, first.unit);
    }
    match rest.all(|other| other.unit == first.unit) {
        true if first.unit == "1" => String::new(),
        true => first.unit.to_owned(),
        false => "units differ, see the names".to_owned(),
    }
}

/// The quarter of a plot that the fewest of its places lie in: to the right, and above.
pub(super) fn emptiest(drawn: &[&Series]) -> (bool, bool) {
    let places = || drawn.iter().flat_map(|series| series.runs.iter().flatten());
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for place in places() {
        for axis in 0..2 {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis]);
        }
    }
    let beyond = |place: &[f64; 2], axis: usize| place[axis] > f64::midpoint(low[axis], high[axis]);
    let inside = |(right, above): (bool, bool)| {
        places().filter(|place| beyond(place, 0) == right && beyond(place, 1) == above).count()
    };
    let quarters = [(true, true), (false, true), (true, false), (false, false)];
    quarters.into_iter().min_by_key(|quarter| inside(*quarter)).unwrap_or((true, true))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use orograph_core::Unit;

    use super::*;

    fn table() -> Table {
        let column = |name: &str, unit, cells| Column { name: name.into(), unit, cells };
        Table::new(vec![
            column("name", Unit::One, Cells::Texts(vec!["a".into(), "b".into(), "c".into(), "d".into()])),
            column("lag", Unit::Metre, Cells::Numbers(vec![1.0, 10.0, 100.0, 1000.0])),
            column("sill", Unit::Metre, Cells::Numbers(vec![5.0, f64::NAN, 0.0, 7.0])),
            column("pairs", Unit::One, Cells::Numbers(vec![1.0, 2.0, 3.0, 4.0])),
        ])
        .unwrap()
    }

    #[test]
    fn a_void_cell_interrupts_its_line() {
        let drawn = series(&table(), &Choice::default());
        let names: Vec<_> = drawn.iter().map(|series| series.name.as_str()).collect();
        assert_eq!(names, ["sill", "pairs"]);
        assert_eq!(drawn[0].runs, [vec![[1.0, 5.0]], vec![[100.0, 0.0], [1000.0, 7.0]]]);
    }

    #[test]
    fn logarithms_leave_out_what_has_none() {
        let choice = Choice { log: [true, true], hidden: vec!["pairs".into()], ..Choice::default() };
        let drawn = series(&table(), &choice);
        assert_eq!(drawn.len(), 1);
        assert_eq!(drawn[0].runs, [vec![[0.0, libm::log10(5.0)]], vec![[3.0, libm::log10(7.0)]]]);
    }

    #[test]
    fn over_rows_the_first_column_is_drawn_as_well() {
        let choice = Choice { over_rows: true, ..Choice::default() };
        assert_eq!(offered(&table(), &choice), ["lag", "sill", "pairs"]);
        assert_eq!(series(&table(), &choice)[0].runs[0][3], [4.0, 1000.0]);
        assert_eq!(offered(&table(), &Choice::default()), ["sill", "pairs"]);
    }

    #[test]
    fn columns_of_another_unit_than_most_are_not_drawn_at_first() {
        let choice = Choice { over_rows: true, ..Choice::default() };
        assert_eq!(strangers(&table(), &choice), ["pairs"]);
        assert_eq!(strangers(&table(), &Choice::default()), ["sill"], "of one and one the later is drawn");
    }

    #[test]
    fn names_stand_where_nothing_is_drawn() {
        let run = |places: &[[f64; 2]]| Series { name: "a".into(), unit: "m", runs: vec![places.to_vec()] };
        let rising = run(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]);
        let falling = run(&[[0.0, 3.0], [1.0, 2.0], [2.0, 1.0], [3.0, 0.0]]);
        assert_eq!(emptiest(&[&rising]), (false, true));
        assert_eq!(emptiest(&[&falling]), (true, true));
        assert_eq!(emptiest(&[]), (true, true));
    }

    #[test]
    fn axes_say_names_and_units() {
        let drawn = series(&table(), &Choice::default());
        assert_eq!(title("lag", "m"), "lag (m)");
        assert_eq!(title("share_above", "%"), "share above (%)");
        assert_eq!(vertical_title(&drawn[..1]), "sill (m)");
        assert_eq!(vertical_title(&drawn), "units differ, see the names");
    }
}

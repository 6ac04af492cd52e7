//! `orograph sweep`: one graph for every combination of parameter values, as a contact sheet and a table.
//!
//! All combinations become one graph, so that what they share is computed once and the rest side by side.

mod sheet;
mod values;

use std::{collections::BTreeSet, sync::Arc};

use orograph_core::{Cells, Column, NodeType, ParamValue, Params, Table, Unit, Value, ValueType};
use orograph_engine::{
    Compiled, Document, GraphBuilder, GraphError, NodeId, OutputRef, Registry, Report, Request,
};
use orograph_nodes::look::{colour_relief::ColourRelief, contact_sheet::ContactSheet};
use orograph_session::targets::refuse_missing;

use crate::{arguments::SweepOptions, console, failure::Failure, manifest::value_text, progress, session};
use values::{Axis, combinations};

/// One setting of all axes.
type Combination = Vec<(String, String)>;

pub(crate) fn run(options: &SweepOptions) -> Result<(), Failure> {
    let registry = session::registry(&options.evaluation.plugins, options.evaluation.cache.as_deref())?;
    let document = Document::load(&options.settings.graph)?;
    let axes = options.params.iter().map(|text| Axis::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let count = axes.iter().fold(1_usize, |count, axis| count.saturating_mul(axis.values.len()));
    if count > options.limit {
        return Err(Failure::usage(
            format!("the sweep has {count} combinations, more than {}", options.limit),
            "give fewer values, or raise --limit",
        ));
    }
    let combinations = combinations(&axes);
    let Merged { builder, cells } = merge(&document, options, &combinations, &registry)?;
    let evaluator = session::evaluator(&options.evaluation)?;
    let graph = builder.build().map_err(wrong)?;
    let request = Request {
        graph: Arc::new(graph),
        outputs: cells.iter().flatten().map(|cell| cell.output).collect(),
        writers: Vec::new(),
        context: session::context(&options.evaluation),
        out_dir: options.evaluation.out.clone(),
        history: None,
    };
    let cancel = session::cancel_on_signal();
    let (observer, bar) = progress::observer(options.evaluation.quiet);
    let report = evaluator.run(request, observer, &cancel);
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    evaluator.flush();
    if report.was_cancelled() {
        return Err(Failure::Cancelled);
    }
    let table = table(&axes, &combinations, &cells, &report.values)
        .map_err(|error| Failure::Other(error.to_string()))?;
    let labels: Vec<String> = combinations.iter().map(label).collect();
    let columns = if axes.len() > 1 { axes[axes.len() - 1].values.len() } else { 0 };
    let sheets = sheet::Sheets { labels: &labels, columns, cells: &cells, values: &report.values };
    let files = sheets
        .write(&options.evaluation.out, options.thumbnail, &table)
        .map_err(|error| Failure::Other(error.to_string()))?;
    console::result(&value_text(&Value::Table(Arc::new(table))).unwrap_or_default());
    for file in files {
        console::result(&options.evaluation.out.join(file).display().to_string());
    }
    tell_failures(&report)
}

/// An output of one combination.
struct Cell {
    /// Its name in the graph.
    name: String,
    output: OutputRef,
    picture: bool,
}

struct Merged {
    builder: GraphBuilder,
    /// For each combination, its outputs.
    cells: Vec<Vec<Cell>>,
}

fn merge(
    document: &Document,
    options: &SweepOptions,
    combinations: &[Combination],
    registry: &Registry,
) -> Result<Merged, Failure> {
    let pictures = Pictures::new(options.thumbnail);
    let mut builder = GraphBuilder::new();
    let mut cells = Vec::new();
    for combination in combinations {
        let compiled = session::compile_with(document, &options.settings, combination, registry)?;
        let names = if options.outputs.is_empty() { usual(&compiled) } else { options.outputs.clone() };
        if names.is_empty() {
            return Err(Failure::usage(
                "the graph names no outputs and writes no pictures",
                "name what to collect with --output node.port, or give the graph `outputs`",
            ));
        }
        let outputs = names.iter().map(|name| compiled.output(name)).collect::<Result<Vec<_>, _>>()?;
        refuse_missing(&compiled, outputs.iter().map(|output| output.node), |_| false)?;
        let types: Vec<_> = outputs.iter().map(|output| compiled.graph.value_type(*output)).collect();
        let prefix = label(combination);
        let first = builder.absorb(compiled.graph, &prefix).map_err(wrong)?;
        let mut row = Vec::new();
        for ((name, output), value_type) in names.into_iter().zip(outputs).zip(types) {
            let output = OutputRef { node: NodeId(output.node.0 + first), output: output.output };
            let place = format!("{prefix}/{name}");
            let (output, picture) = pictures.of(&mut builder, output, value_type, &place).map_err(wrong)?;
            row.push(Cell { name, output, picture });
        }
        cells.push(row);
    }
    Ok(Merged { builder, cells })
}

/// What is collected where nothing was asked for: the named outputs; where none of them is seen, the pictures that the
/// graph writes as well.
fn usual(compiled: &Compiled) -> Vec<String> {
    let mut names: Vec<String> = compiled.outputs.keys().cloned().collect();
    let seen = |value_type| matches!(value_type, Some(ValueType::Texture | ValueType::Heightfield));
    if compiled.outputs.values().any(|output| seen(compiled.graph.value_type(*output))) {
        return names;
    }
    let mut pictures = BTreeSet::new();
    for writer in compiled.graph.writers() {
        for output in compiled.graph.node(writer).inputs.iter().flatten() {
            let source = compiled.graph.node(output.node);
            let port = source.spec().and_then(|spec| spec.outputs.get(output.output as usize));
            if let Some(port) = port.filter(|port| port.value_type == ValueType::Texture) {
                pictures.insert(format!("{}.{}", source.name, port.name));
            }
        }
    }
    names.extend(pictures);
    names
}

/// Turns rasters into small pictures, so that a large sweep does not hold large ones.
struct Pictures {
    relief: Arc<NodeType>,
    thumbnail: Arc<NodeType>,
    thumbnail_values: Vec<ParamValue>,
}

impl Pictures {
    fn new(size: u32) -> Self {
        Self {
            relief: Arc::new(NodeType::of::<ColourRelief>()),
            thumbnail: Arc::new(NodeType::of::<ContactSheet>()),
            thumbnail_values: ContactSheet { size, spacing: 1, ..ContactSheet::default() }.to_values(),
        }
    }

    /// The output to ask for, and whether it is a picture.
    fn of(
        &self,
        builder: &mut GraphBuilder,
        output: OutputRef,
        value_type: Option<ValueType>,
        place: &str,
    ) -> Result<(OutputRef, bool), GraphError> {
        let mut picture = output;
        match value_type {
            Some(ValueType::Texture) => {}
            Some(ValueType::Heightfield) => {
                let id = builder.add(
                    &format!("{place} (relief)"),
                    &self.relief,
                    ColourRelief::default().to_values(),
                )?;
                builder.wire(picture, id, "terrain")?;
                picture = OutputRef { node: id, output: 0 };
            }
            _ => return Ok((output, false)),
        }
        let id =
            builder.add(&format!("{place} (thumbnail)"), &self.thumbnail, self.thumbnail_values.clone())?;
        builder.wire(picture, id, "pictures")?;
        Ok((OutputRef { node: id, output: 0 }, true))
    }
}

/// `name=value` of each axis; of a long name only its last part.
fn label(combination: &Combination) -> String {
    let parts: Vec<_> = combination
        .iter()
        .map(|(name, value)| format!("{}={value}", name.rsplit('.').next().unwrap_or(name)))
        .collect();
    parts.join(", ")
}

/// One row for each combination: what was set, then every metric of the tables and scalars.
fn table(
    axes: &[Axis],
    combinations: &[Combination],
    cells: &[Vec<Cell>],
    values: &[Option<Value>],
) -> orograph_core::Result<Table> {
    let mut columns: Vec<Column> = axes
        .iter()
        .enumerate()
        .map(|(i, axis)| {
            let texts = combinations.iter().map(|combination| combination[i].1.clone()).collect();
            Column { name: axis.name.clone(), unit: Unit::One, cells: numbers_where_possible(texts) }
        })
        .collect();
    let n_rows = combinations.len();
    let mut next = values.iter();
    for (row, cells) in cells.iter().enumerate() {
        for (cell, value) in cells.iter().zip(next.by_ref()) {
            for (name, unit, number) in metrics(&cell.name, value.as_ref()) {
                let at = columns.iter().position(|column| column.name == name).unwrap_or_else(|| {
                    let cells = Cells::Numbers(vec![f64::NAN; n_rows]);
                    columns.push(Column { name, unit, cells });
                    columns.len() - 1
                });
                if let Cells::Numbers(numbers) = &mut columns[at].cells {
                    numbers[row] = number;
                }
            }
        }
    }
    Table::new(columns)
}

/// The numbers in an output: each metric of a table of one row, or a scalar itself.
fn metrics(name: &str, value: Option<&Value>) -> Vec<(String, Unit, f64)> {
    match value {
        Some(Value::Number(x)) => vec![(name.to_owned(), Unit::One, *x)],
        Some(Value::Integer(i)) => vec![(name.to_owned(), Unit::One, *i as f64)],
        Some(Value::Table(table)) if table.rows() == 1 => table
            .columns()
            .iter()
            .filter_map(|column| {
                let number = table.metric(&column.name)?;
                Some((format!("{name}.{}", column.name), column.unit, number))
            })
            .collect(),
        _ => Vec::new(),
    }
}

fn numbers_where_possible(texts: Vec<String>) -> Cells {
    match texts.iter().map(|text| text.parse().ok()).collect() {
        Some(numbers) => Cells::Numbers(numbers),
        None => Cells::Texts(texts),
    }
}

fn tell_failures(report: &Report) -> Result<(), Failure> {
    console::failures(report);
    if report.counts().failed > 0 { Err(Failure::Node) } else { Ok(()) }
}

fn wrong(error: GraphError) -> Failure {
    Failure::Other(error.to_string())
}

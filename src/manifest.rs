//! The JSON manifest of a run, and tables as text and JSON.

use orograph_core::{Cells, Table, Value};
use orograph_engine::{Outcome, Report, eval::NodeReport};
use orograph_session::tables::{cell_text, head_text};
use serde_json::{Map, Value as Json, json};

use crate::console;

/// Everything about a run, for a program to read.
pub(crate) fn manifest(report: &Report, results: &[(String, Option<Value>)]) -> Json {
    let status = if report.was_cancelled() {
        "cancelled"
    } else if report.counts().failed > 0 {
        "failed"
    } else {
        "ok"
    };
    let files: Vec<_> = report
        .nodes
        .iter()
        .flat_map(|node| node.files.iter().map(move |file| (node, file)))
        .map(|(node, file)| {
            json!({
                "name": file.name,
                "bytes": file.bytes,
                "digest": file.digest.to_string(),
                "node": node.name,
                "key": node.key.map(|key| key.to_string()),
            })
        })
        .collect();
    let results: Map<String, Json> = results
        .iter()
        .filter_map(|(name, value)| Some((name.clone(), value_json(value.as_ref()?)?)))
        .collect();
    json!({
        "orograph": env!("CARGO_PKG_VERSION"),
        "status": status,
        "counts": report.counts(),
        "results": results,
        "files": files,
        "nodes": report.nodes.iter().map(node_json).collect::<Vec<_>>(),
    })
}

fn node_json(node: &NodeReport) -> Json {
    let outputs: Map<String, Json> =
        node.outputs.iter().map(|(name, digest)| (name.clone(), Json::from(digest.to_string()))).collect();
    let mut json = json!({
        "name": node.name,
        "node": node.id,
        "version": node.version,
        "outcome": node.outcome.word(),
        "key": node.key.map(|key| key.to_string()),
        "outputs": outputs,
        "bytes": node.bytes,
        "seconds": node.micros as f64 / 1e6,
    });
    if let Some(reason) = &node.reason {
        json["reason"] = reason.clone().into();
    }
    if !node.warnings.is_empty() {
        json["warnings"] = node.warnings.clone().into();
    }
    match &node.outcome {
        Outcome::Failed(error) => {
            json["error"] = error.to_string().into();
            json["hint"] = error.hint().into();
        }
        Outcome::Skipped { because } => json["because"] = because.clone().into(),
        _ => {}
    }
    json
}

/// A table or scalar as JSON; nothing for what belongs into a file.
fn value_json(value: &Value) -> Option<Json> {
    Some(match value {
        Value::Table(table) => table_json(table),
        Value::Number(x) => json!(x),
        Value::Integer(i) => json!(i),
        Value::Boolean(b) => json!(b),
        Value::Text(text) => json!(text.as_ref()),
        _ => return None,
    })
}

/// A table as JSON: columns by name, each with its unit and its cells.
fn table_json(table: &Table) -> Json {
    let columns: Map<String, Json> = table
        .columns()
        .iter()
        .map(|column| {
            let cells = match &column.cells {
                Cells::Numbers(cells) => json!(cells),
                Cells::Texts(cells) => json!(cells),
            };
            (column.name.clone(), json!({"unit": column.unit.symbol(), "values": cells}))
        })
        .collect();
    Json::Object(columns)
}

/// A table or scalar for people; nothing for what belongs into a file.
pub(crate) fn value_text(value: &Value) -> Option<String> {
    Some(match value {
        Value::Table(table) => table_text(table),
        Value::Number(x) => x.to_string(),
        Value::Integer(i) => i.to_string(),
        Value::Boolean(b) => b.to_string(),
        Value::Text(text) => text.to_string(),
        _ => return None,
    })
}

/// One metric a line for a single row, otherwise one row a line.
fn table_text(table: &Table) -> String {
    let heads = table.columns().iter().map(head_text);
    if table.rows() == 1 {
        let rows: Vec<_> = heads
            .zip(table.columns())
            .map(|(head, column)| vec![head, cell_text(&column.cells, 0)])
            .collect();
        return console::columns(&rows);
    }
    let mut rows = vec![heads.collect::<Vec<_>>()];
    rows.extend(
        (0..table.rows())
            .map(|row| table.columns().iter().map(|column| cell_text(&column.cells, row)).collect()),
    );
    console::columns(&rows)
}

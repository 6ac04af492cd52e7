//! Graphs with nodes more, which make pictures of what is looked at.

use orograph_core::{NodeSpec, ParamValue};
use orograph_engine::{Graph, GraphBuilder, GraphError, NodeId, OutputRef, Registry};

use crate::{
    looks::{self, LARGEST},
    teller::LOOK,
};

/// A graph under construction.
pub(crate) struct Chain<'a> {
    registry: &'a Registry,
    builder: GraphBuilder,
    added: usize,
}

impl<'a> Chain<'a> {
    /// Begins with the nodes of the document.
    pub(crate) fn on(graph: &Graph, registry: &'a Registry) -> Self {
        Self { registry, builder: graph.clone().into_builder(), added: 0 }
    }

    /// A picture that a look makes of an output, over another picture where there is one.
    pub(crate) fn look(
        &mut self,
        look: &str,
        output: OutputRef,
        over: Option<OutputRef>,
    ) -> Result<OutputRef, String> {
        let over = over.and_then(|over| Some((over, looks::ground_port(self.spec(look).ok()?)?.to_owned())));
        let node = self.add(look, &[])?;
        self.wire(output, node, look, 0)?;
        if let Some((over, port)) = over {
            self.builder.wire(over, node, &port).map_err(|error| error.to_string())?;
        }
        self.picture(look, node)
    }

    /// A picture of where the first output lies above the second; `shares` says that they are masks.
    pub(crate) fn difference(
        &mut self,
        pair: [OutputRef; 2],
        shares: bool,
        largest: f64,
    ) -> Result<OutputRef, String> {
        let mut terrains = pair;
        if shares {
            for terrain in &mut terrains {
                // A share of one is a metre high, so that metres are shares.
                let levels = [("low", ParamValue::Number(0.0)), ("high", ParamValue::Number(1.0))];
                let node = self.add(TO_HEIGHT, &levels)?;
                self.wire(*terrain, node, TO_HEIGHT, 0)?;
                *terrain = OutputRef { node, output: 0 };
            }
        }
        let settings = [
            ("automatic", ParamValue::Boolean(false)),
            (LARGEST, ParamValue::Number(largest)),
            ("legend", ParamValue::Boolean(false)),
        ];
        let node = self.add(looks::DIFFERENCE, &settings)?;
        for (port, terrain) in terrains.into_iter().enumerate() {
            self.wire(terrain, node, looks::DIFFERENCE, port)?;
        }
        self.picture(looks::DIFFERENCE, node)
    }

    /// The whole.
    pub(crate) fn build(self) -> Result<Graph, String> {
        self.builder.build().map_err(|error| error.to_string())
    }

    fn spec(&self, id: &str) -> Result<&'a NodeSpec, String> {
        let node_type = self.registry.get(id).ok_or_else(|| format!("there is no view `{id}`"))?;
        Ok(node_type.spec())
    }

    fn add(&mut self, id: &str, settings: &[(&str, ParamValue)]) -> Result<NodeId, String> {
        let Some(node_type) = self.registry.get(id) else { return Err(format!("there is no view `{id}`")) };
        let value = |param: &orograph_core::ParamSpec| {
            let set = settings.iter().find(|(name, _)| *name == param.name);
            set.map_or_else(|| param.default.clone(), |(_, value)| value.clone())
        };
        let values = node_type.spec().params.iter().map(value).collect();
        let name = format!("{LOOK} {}", self.added);
        self.added += 1;
        self.builder.add(&name, node_type, values).map_err(|error| error.to_string())
    }

    fn wire(&mut self, from: OutputRef, to: NodeId, id: &str, port: usize) -> Result<(), String> {
        let input = self.spec(id)?.inputs.get(port).map(|port| port.name.to_string()).unwrap_or_default();
        self.builder.wire(from, to, &input).map_err(|error: GraphError| error.to_string())
    }

    fn picture(&self, id: &str, node: NodeId) -> Result<OutputRef, String> {
        let output = looks::picture_port(self.spec(id)?).ok_or_else(|| format!("`{id}` makes no picture"))?;
        Ok(OutputRef { node, output })
    }
}

/// Makes terrain of a mask.
const TO_HEIGHT: &str = "mask.to_height";

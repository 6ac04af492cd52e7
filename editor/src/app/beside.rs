//! What a pane is offered: outputs to show, and what its picture can show besides: the other pane's value, or the
//! terrain below.

use orograph_core::ValueType;
use orograph_edit::{Beside, beside::ground, looks};
use orograph_engine::document::Link;

use super::{App, sketch::Drawable};
use crate::views::Offer;

impl App {
    /// What stands to be shown in a pane.
    pub(super) fn offer(&mut self, index: usize, drawable: Option<&Drawable>) -> Offer {
        let strokes = self.strokes_for(index, drawable);
        let Some(output) = self.panes[index].output.clone() else { return Offer::default() };
        let document = self.editing.document().clone();
        let Some(node) = document.nodes.get(&output.node) else { return Offer::default() };
        let interface = self.interfaces.of(&output.node, node, &document);
        let value_type = interface.output(&output.port).and_then(|port| port.value_type);
        let outputs = interface.outputs.iter().map(|port| Link::new(&output.node, &port.name)).collect();
        Offer { value_type, outputs, strokes }
    }

    /// What goes with the wish of a pane.
    pub(super) fn beside(&mut self, index: usize, value_type: Option<ValueType>) -> Beside {
        let pane = &self.panes[index];
        let (Some(output), Some(value_type)) = (pane.output.clone(), value_type) else {
            return Beside::Nothing;
        };
        let others: Vec<_> = self.panes.iter().enumerate().filter(|(i, _)| *i != index).collect();
        let mut others = others.into_iter().filter_map(|(_, pane)| pane.output.clone());
        if pane.compares() && looks::can_be_compared(value_type) {
            return others.next().map_or(Beside::Nothing, Beside::Against);
        }
        if !pane.draws_over(&self.registry, value_type) {
            return Beside::Nothing;
        }
        let shown: Vec<_> = others.collect();
        let document = self.editing.document().clone();
        let mut grounds = ground(&document, &mut self.interfaces, &output);
        // What is looked at beside it may be its ground as well.
        for link in shown {
            if self.type_of(&link) == Some(ValueType::Heightfield) && !grounds.contains(&link) {
                grounds.push(link);
            }
        }
        if grounds.is_empty() { Beside::Nothing } else { Beside::Over(grounds) }
    }
}

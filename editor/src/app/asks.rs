//! What the inspector asks for, made edits.

use orograph_core::ParamValue;
use orograph_edit::{Interfaces, Kind, operations, operations::Refused};
use orograph_engine::{
    Document,
    compile::lifted,
    document::{Link, Literal},
};

use super::{App, Question, dialogs::For, help::Page, variations::Variations};
use crate::inspector::Ask;

impl App {
    /// Does what the inspector asks for.
    pub(super) fn ask(&mut self, ask: Ask) {
        match ask {
            Ask::Done => self.editing.end_gesture(),
            Ask::Set(link, value) => self.set(&link, &value),
            Ask::Reset(link) => {
                self.edit("reset", |document, interfaces| {
                    lift(document, interfaces, &link.node)?;
                    operations::set_param(document, &link.node, &link.port, None)
                });
            }
            Ask::Expose(link) => {
                self.edit("expose", |document, _| Ok(operations::expose(document, link)));
            }
            Ask::Hide(name) => {
                self.edit("do not expose", |document, _| Ok(document.expose.shift_remove(&name)));
            }
            Ask::Vary(link) => self.vary(link),
            Ask::Rename(old, new) => {
                let renamed =
                    self.editing.edit("rename", |document| operations::rename(document, &old, &new));
                match renamed {
                    Ok(()) => {
                        self.canvas.select([new]);
                        self.inspector.name_refused = None;
                    }
                    Err(refused) => {
                        self.inspector.name_refused = Some(refused.to_string());
                    }
                }
            }
            Ask::Comment(name, comment) => {
                let _: Result<(), Refused> =
                    self.editing.drag(&format!("comment {name}"), "comment", |document| {
                        if let Some(node) = document.nodes.get_mut(&name) {
                            node.comment = comment;
                        }
                        Ok(())
                    });
            }
            Ask::Doc(doc) => {
                let _: Result<(), Refused> = self.editing.drag("about", "about the graph", |document| {
                    document.doc = doc;
                    Ok(())
                });
            }
            Ask::Bypass(name) => {
                self.edit("bypass", |document, _| {
                    operations::toggle_bypass(document, &[&name]);
                    Ok(())
                });
            }
            Ask::File(link, writes) => {
                let question = if writes { Question::Output } else { Question::Input };
                self.ask_file(question, For::Param(link));
            }
            Ask::Help(name) => {
                let document = self.editing.document().clone();
                if let Some(node) = document.nodes.get(&name)
                    && let Some(spec) = self.interfaces.of(&name, node, &document).spec()
                {
                    self.help = Some(Page::node(spec.clone()));
                }
            }
            Ask::AddOutput(link) => {
                self.edit("name output", |document, _| Ok(operations::add_output(document, link)));
            }
            Ask::RemoveOutput(name) => {
                self.edit("remove output", |document, _| Ok(document.outputs.shift_remove(&name)));
            }
        }
    }

    /// Sets a parameter; edits in a row of one parameter are one step until the widget is let go.
    pub(super) fn set(&mut self, link: &Link, value: &ParamValue) {
        let interfaces = &mut self.interfaces;
        let literal = Literal::from(value);
        let done = self.editing.drag(&format!("set {link}"), &format!("set {link}"), |document| {
            lift(document, interfaces, &link.node)?;
            operations::set_param(document, &link.node, &link.port, Some(literal))
        });
        if let Err(refused) = done {
            self.complain(refused.to_string());
        }
    }

    fn vary(&mut self, link: Link) {
        let document = self.editing.document().clone();
        let Some(node) = document.nodes.get(&link.node) else { return };
        let interface = self.interfaces.of(&link.node, node, &document);
        let Some(offered) = interface.params.iter().find(|param| param.name == link.port) else { return };
        let Some(output) = self.panes.first().and_then(|pane| pane.output.clone()) else { return };
        let Some(value_type) = self.type_of(&output) else { return };
        let Some(look) = self.interfaces.first_look(value_type) else {
            self.complain(format!("`{output}` has no picture"));
            return;
        };
        self.variations = Some(Variations::new(link, &offered.spec, output, look));
    }
}

/// Brings a node's settings up to the current version of its type before one of them changes.
fn lift(document: &mut Document, interfaces: &mut Interfaces, name: &str) -> Result<(), Refused> {
    let Some(node) = document.nodes.get(name) else { return Ok(()) };
    if let Kind::Type(node_type) = &interfaces.of(name, node, document).kind {
        let lifted = lifted(node, node_type)
            .map_err(|error| Refused::new(error.to_string(), error.hint().unwrap_or_default()))?;
        document.nodes.insert(name.to_owned(), lifted);
    }
    Ok(())
}

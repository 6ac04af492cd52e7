//! Everything that a menu entry or a key does: name, key and menu stand here and nowhere else.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

/// Something to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Begins a new graph.
    New,
    /// Opens a graph file.
    Open,
    /// Saves the graph.
    Save,
    /// Saves the graph under another name.
    SaveAs,
    /// Closes the window.
    Quit,
    /// Takes the last step back.
    Undo,
    /// Makes it again.
    Redo,
    /// Moves the selected nodes to the clipboard.
    Cut,
    /// Puts the selected nodes on the clipboard, as text.
    Copy,
    /// Adds the nodes on the clipboard.
    Paste,
    /// Adds the selected nodes a second time.
    Duplicate,
    /// Removes the selected nodes and wires.
    Delete,
    /// Removes the selected nodes and joins their wires.
    Dissolve,
    /// Selects every node.
    SelectAll,
    /// Selects no node.
    SelectNone,
    /// Adds a node by searching for it.
    Add,
    /// Adds a graph file as a node.
    AddGraph,
    /// Bypasses the selected nodes, or ends that.
    Bypass,
    /// Puts a frame around the selected nodes.
    Frame,
    /// Puts words between the nodes.
    Comment,
    /// Leads the selected wires through a place more.
    Bend,
    /// Folds the selected nodes into a graph of their own.
    Collapse,
    /// Lays a graph that is a node out again.
    Expand,
    /// Gives the selected nodes one left edge.
    AlignLeft,
    /// Gives the selected nodes one top edge.
    AlignTop,
    /// Lays out all nodes anew.
    Arrange,
    /// Shows the whole graph.
    Fit,
    /// The pane stays with what it shows, or follows the selection again.
    Pin,
    /// A second pane, or no longer.
    Split,
    /// Pictures on nodes, or none.
    Thumbnails,
    /// Selects the next node along the wires.
    Next,
    /// Selects the node before, against the wires.
    Previous,
    /// Runs the graph as `orograph run` does.
    Build,
    /// Stops what is under way.
    Stop,
    /// Tells of the keys.
    Keys,
    /// Settings of the program.
    Settings,
}

/// A menu.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Menu {
    /// Files.
    File,
    /// The document.
    Edit,
    /// Nodes.
    Node,
    /// What is seen.
    View,
    /// Evaluation.
    Run,
    /// Words about the program.
    Help,
}

impl Menu {
    /// All of them, in order.
    pub(super) const ALL: [(Self, &'static str); 6] = [
        (Self::File, "File"),
        (Self::Edit, "Edit"),
        (Self::Node, "Node"),
        (Self::View, "View"),
        (Self::Run, "Run"),
        (Self::Help, "Help"),
    ];
}

const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const NONE: Modifiers = Modifiers::NONE;

/// How a command is called and reached.
pub(super) struct Entry {
    /// The command.
    pub(super) command: Command,
    /// Its name.
    pub(super) label: &'static str,
    /// Its menu.
    pub(super) menu: Menu,
    /// Its key.
    pub(super) key: Option<(Modifiers, Key)>,
}

const fn entry(command: Command, label: &'static str, menu: Menu, key: Option<(Modifiers, Key)>) -> Entry {
    Entry { command, label, menu, key }
}

/// Every command, in the order in which menus and the list of keys show them.
pub(super) const ENTRIES: [Entry; 38] = [
    entry(Command::New, "New", Menu::File, Some((CTRL, Key::N))),
    entry(Command::Open, "Open…", Menu::File, Some((CTRL, Key::O))),
    entry(Command::Save, "Save", Menu::File, Some((CTRL, Key::S))),
    entry(Command::SaveAs, "Save as…", Menu::File, Some((CTRL.plus(SHIFT), Key::S))),
    entry(Command::Settings, "Settings…", Menu::File, Some((CTRL, Key::Comma))),
    entry(Command::Quit, "Quit", Menu::File, Some((CTRL, Key::Q))),
    entry(Command::Undo, "Undo", Menu::Edit, Some((CTRL, Key::Z))),
    entry(Command::Redo, "Redo", Menu::Edit, Some((CTRL.plus(SHIFT), Key::Z))),
    // These three come as events of the system, with its own keys.
    entry(Command::Cut, "Cut", Menu::Edit, None),
    entry(Command::Copy, "Copy", Menu::Edit, None),
    entry(Command::Paste, "Paste", Menu::Edit, None),
    entry(Command::Duplicate, "Duplicate", Menu::Edit, Some((CTRL, Key::D))),
    entry(Command::Delete, "Delete", Menu::Edit, Some((NONE, Key::Delete))),
    entry(Command::Dissolve, "Delete and join wires", Menu::Edit, Some((CTRL, Key::Delete))),
    entry(Command::SelectAll, "Select all", Menu::Edit, Some((CTRL, Key::A))),
    entry(Command::SelectNone, "Select none", Menu::Edit, Some((CTRL.plus(SHIFT), Key::A))),
    entry(Command::Add, "Add node…", Menu::Node, Some((NONE, Key::Tab))),
    entry(Command::AddGraph, "Add graph as node…", Menu::Node, None),
    entry(Command::Bypass, "Bypass", Menu::Node, Some((NONE, Key::B))),
    entry(Command::Frame, "Frame", Menu::Node, Some((NONE, Key::F))),
    entry(Command::Comment, "Comment…", Menu::Node, Some((NONE, Key::C))),
    entry(Command::Bend, "Bend wires", Menu::Node, Some((NONE, Key::W))),
    entry(Command::Collapse, "Collapse into subgraph…", Menu::Node, Some((CTRL, Key::G))),
    entry(Command::Expand, "Expand subgraph", Menu::Node, Some((CTRL.plus(SHIFT), Key::G))),
    entry(Command::AlignLeft, "Align left edges", Menu::Node, Some((NONE, Key::L))),
    entry(Command::AlignTop, "Align top edges", Menu::Node, Some((NONE, Key::T))),
    entry(Command::Arrange, "Arrange all", Menu::Node, None),
    entry(Command::Fit, "Show all", Menu::View, Some((NONE, Key::Home))),
    entry(Command::Pin, "Pin the pane", Menu::View, Some((NONE, Key::P))),
    entry(Command::Split, "Second pane", Menu::View, Some((NONE, Key::V))),
    entry(Command::Thumbnails, "Pictures on nodes", Menu::View, None),
    entry(Command::Next, "Next node", Menu::View, Some((NONE, Key::ArrowRight))),
    entry(Command::Previous, "Previous node", Menu::View, Some((NONE, Key::ArrowLeft))),
    entry(Command::Build, "Build", Menu::Run, Some((CTRL, Key::B))),
    entry(Command::Stop, "Stop", Menu::Run, Some((NONE, Key::Escape))),
    entry(Command::Keys, "Keys", Menu::Help, Some((NONE, Key::F1))),
    // On systems where redo is Ctrl+Y.
    entry(Command::Redo, "", Menu::Edit, Some((CTRL, Key::Y))),
    entry(Command::Delete, "", Menu::Edit, Some((NONE, Key::Backspace))),
];

/// Every command in the order in which keys are given to them: one without Shift would take the key of one with it.
pub(super) fn asked_first() -> impl Iterator<Item = &'static Entry> {
    let shifted = |entry: &&Entry| entry.key.is_some_and(|(modifiers, _)| modifiers.shift);
    ENTRIES.iter().filter(shifted).chain(ENTRIES.iter().filter(move |entry| !shifted(entry)))
}

impl Entry {
    /// Its key as egui has it.
    #[must_use]
    pub(super) fn shortcut(&self) -> Option<KeyboardShortcut> {
        self.key.map(|(modifiers, key)| KeyboardShortcut::new(modifiers, key))
    }

    /// Its key as it is told: also of the three that come as events of the system.
    #[must_use]
    pub(super) fn told(&self) -> Option<KeyboardShortcut> {
        let key = match self.command {
            Command::Cut => Key::X,
            Command::Copy => Key::C,
            Command::Paste => Key::V,
            _ => return self.shortcut(),
        };
        Some(KeyboardShortcut::new(CTRL, key))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_a_key() {
        for (index, a) in ENTRIES.iter().enumerate() {
            let twin = ENTRIES[index + 1..].iter().find(|b| a.key.is_some() && a.key == b.key);
            assert!(twin.is_none(), "{:?} and {:?}", a.command, twin.map(|entry| entry.command));
        }
    }

    #[test]
    fn of_commands_with_one_key_the_ones_with_more_modifiers_are_asked_first() {
        let entries: Vec<_> = asked_first().collect();
        assert_eq!(entries.len(), ENTRIES.len());
        for (index, first) in entries.iter().enumerate() {
            for later in &entries[index + 1..] {
                // A key without Shift takes the one with Shift, too; Ctrl has to match.
                if let (Some((first, a)), Some((later, b))) = (first.key, later.key)
                    && a == b
                    && first.command == later.command
                {
                    assert!(first.shift || !later.shift, "{a:?} would be taken by the wrong one");
                }
            }
        }
    }
}

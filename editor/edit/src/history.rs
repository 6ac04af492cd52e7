//! A document with everything that was done to it: undo and redo without limit.

use std::sync::Arc;

use orograph_engine::Document;

use crate::{Delta, operations};

/// A document that is being edited.
#[derive(Debug)]
pub struct Editing {
    document: Arc<Document>,
    done: Vec<Step>,
    undone: Vec<Step>,
    /// A gesture that goes on: further edits of its name join its step.
    gesture: Option<Gesture>,
    /// States have numbers, so that one knows whether the state that was saved is the one at hand.
    state: u64,
    last_state: u64,
    saved: u64,
}

#[derive(Debug)]
struct Step {
    label: String,
    delta: Delta,
    before: u64,
    after: u64,
}

#[derive(Debug)]
struct Gesture {
    name: String,
    base: Arc<Document>,
    base_state: u64,
}

impl Editing {
    /// Begins to edit a document that is as it was saved.
    #[must_use]
    pub fn new(document: Document) -> Self {
        Self {
            document: Arc::new(document),
            done: Vec::new(),
            undone: Vec::new(),
            gesture: None,
            state: 0,
            last_state: 0,
            saved: 0,
        }
    }

    /// The document as it is now; cheap to share with who runs it.
    #[must_use]
    pub fn document(&self) -> &Arc<Document> {
        &self.document
    }

    /// The number of the present state; another one whenever the document is another one.
    #[must_use]
    pub fn state(&self) -> u64 {
        self.state
    }

    /// Makes an edit, which `label` names in the menu. One that fails or changes nothing leaves no trace.
    ///
    /// # Errors
    /// Those of the edit.
    pub fn edit<T, E>(
        &mut self,
        label: &str,
        edit: impl FnOnce(&mut Document) -> Result<T, E>,
    ) -> Result<T, E> {
        self.end_gesture();
        let mut next = (*self.document).clone();
        let result = edit(&mut next)?;
        operations::forget_bends(&mut next);
        let delta = Delta::between(&self.document, &next);
        if !delta.is_empty() {
            self.push(label, delta, self.state, next);
        }
        Ok(result)
    }

    /// Makes an edit that is part of a longer gesture, such as the drag of a slider: all edits in a row under the
    /// same `gesture` are one step of the history, until [`Editing::end_gesture`].
    ///
    /// # Errors
    /// Those of the edit.
    pub fn drag<T, E>(
        &mut self,
        gesture: &str,
        label: &str,
        edit: impl FnOnce(&mut Document) -> Result<T, E>,
    ) -> Result<T, E> {
        let goes_on = self.gesture.as_ref().is_some_and(|now| now.name == gesture);
        let mut next = (*self.document).clone();
        let result = edit(&mut next)?;
        operations::forget_bends(&mut next);
        if *self.document == next {
            return Ok(result);
        }
        if !goes_on {
            let (base, base_state) = (self.document.clone(), self.state);
            self.gesture = Some(Gesture { name: gesture.to_owned(), base, base_state });
        }
        let Some(Gesture { base, base_state, .. }) = &self.gesture else { return Ok(result) };
        let (delta, base_state) = (Delta::between(base, &next), *base_state);
        if self.done.last().is_some_and(|step| step.before == base_state) {
            self.done.pop();
        }
        if delta.is_empty() {
            // Back where it began.
            (self.document, self.state) = (Arc::new(next), base_state);
        } else {
            self.push(label, delta, base_state, next);
        }
        Ok(result)
    }

    /// Ends a gesture: the next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    fn push(&mut self, label: &str, delta: Delta, before: u64, next: Document) {
        self.last_state += 1;
        self.state = self.last_state;
        self.document = Arc::new(next);
        self.undone.clear();
        self.done.push(Step { label: label.to_owned(), delta, before, after: self.state });
    }

    /// What undo would take back.
    #[must_use]
    pub fn undo_label(&self) -> Option<&str> {
        self.done.last().map(|step| step.label.as_str())
    }

    /// What redo would do again.
    #[must_use]
    pub fn redo_label(&self) -> Option<&str> {
        self.undone.last().map(|step| step.label.as_str())
    }

    /// Takes the last step back; `false` when there is none.
    pub fn undo(&mut self) -> bool {
        self.end_gesture();
        let Some(step) = self.done.pop() else { return false };
        self.turn(&step.delta.inverse(), step.before);
        self.undone.push(step);
        true
    }

    /// Makes the last step that was taken back again; `false` when there is none.
    pub fn redo(&mut self) -> bool {
        self.end_gesture();
        let Some(step) = self.undone.pop() else { return false };
        self.turn(&step.delta, step.after);
        self.done.push(step);
        true
    }

    fn turn(&mut self, delta: &Delta, state: u64) {
        let applied = delta.apply(Arc::make_mut(&mut self.document));
        debug_assert!(applied.is_ok(), "a step of the history fits the document that it was made on");
        self.state = state;
    }

    /// Whether there is something to save.
    #[must_use]
    pub fn is_dirty(&self) -> bool {
        self.state != self.saved
    }

    /// Ends the gesture that goes on and gives the number of the present state, which is to be saved.
    pub fn to_be_saved(&mut self) -> u64 {
        self.end_gesture();
        self.state
    }

    /// Notes that the state of that number was saved, whatever was edited since.
    pub fn saved(&mut self, state: u64) {
        self.saved = state;
    }

    /// Notes that the present state is not the one of the file, as after a recovery.
    pub fn never_saved(&mut self) {
        self.saved = u64::MAX;
    }
}

//! The one stack of commands: every change of the scene document goes through it, and back.

use lumivox_core::document::SceneDocument;

use crate::words::Word;

/// A document, and how it came to be.
#[derive(Debug)]
pub struct History {
    present: SceneDocument,
    past: Vec<Step>,
    future: Vec<Step>,
    /// Whether the last step goes on: a slider that is still held.
    is_open: bool,
}

/// A document before (or after) a change, and what changed.
#[derive(Debug)]
struct Step {
    what: Word,
    document: SceneDocument,
}

/// More steps are forgotten; documents are small, but nobody goes back so far.
const MOST_STEPS: usize = 500;

impl History {
    /// Begins with a document.
    pub fn new(present: SceneDocument) -> Self {
        Self { present, past: vec![], future: vec![], is_open: false }
    }

    /// The document as it is.
    pub fn document(&self) -> &SceneDocument {
        &self.present
    }

    /// Makes the document another by a change of that name; true where it is another. While a slider is held it is one step, and
    /// so are all turns of the camera after each other.
    pub fn change(&mut self, what: Word, document: SceneDocument) -> bool {
        if document == self.present {
            return false;
        }
        let goes_on = self.past.last().is_some_and(|step| step.what == what)
            && (self.is_open || what == Word::Camera)
            && self.future.is_empty();
        let before = std::mem::replace(&mut self.present, document);
        if !goes_on {
            self.past.push(Step { what, document: before });
            if self.past.len() > MOST_STEPS {
                self.past.remove(0);
            }
        }
        self.future.clear();
        self.is_open = true;
        true
    }

    /// Nothing is held any more: the next change is a step of its own.
    pub fn close(&mut self) {
        self.is_open = false;
    }

    /// Goes back a step; false where there is none.
    pub fn undo(&mut self) -> bool {
        let Some(step) = self.past.pop() else { return false };
        let after = std::mem::replace(&mut self.present, step.document);
        self.future.push(Step { what: step.what, document: after });
        self.is_open = false;
        true
    }

    /// Goes forward again; false where nothing was undone.
    pub fn redo(&mut self) -> bool {
        let Some(step) = self.future.pop() else { return false };
        let before = std::mem::replace(&mut self.present, step.document);
        self.past.push(Step { what: step.what, document: before });
        self.is_open = false;
        true
    }

    /// Changes all documents that there are, were and would be again. Steps between two that are the same now are gone.
    pub fn rewrite(&mut self, change: impl Fn(&mut SceneDocument)) {
        change(&mut self.present);
        for steps in [&mut self.past, &mut self.future] {
            // From the present on, which is the neighbour of the last.
            let mut near = self.present.clone();
            let mut kept = vec![];
            for mut step in steps.drain(..).rev() {
                change(&mut step.document);
                if step.document != near {
                    near = step.document.clone();
                    kept.push(step);
                }
            }
            kept.reverse();
            *steps = kept;
        }
        self.is_open = false;
    }

    /// What would be undone, and what done again.
    pub fn next(&self) -> [Option<Word>; 2] {
        [self.past.last(), self.future.last()].map(|step| step.map(|step| step.what))
    }
}

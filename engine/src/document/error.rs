//! What is wrong with a graph file, and where: file, line, column, and the mend.

use std::{fmt, ops::Range, sync::Arc};

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};

/// The text of a graph file, kept for messages.
#[derive(Clone, Debug)]
pub(crate) struct SourceText(Arc<NamedSource<Arc<str>>>);

impl SourceText {
    pub(crate) fn new(path: &str, text: Arc<str>) -> Self {
        Self(Arc::new(NamedSource::new(path, text)))
    }

    pub(crate) fn path(&self) -> &str {
        self.0.name()
    }

    pub(crate) fn text(&self) -> &str {
        self.0.inner()
    }

    /// Line and column of a byte, both from 1; columns count characters.
    fn position(&self, offset: usize) -> (usize, usize) {
        let text = self.text();
        let mut end = offset.min(text.len());
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &text[..end];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (1 + before.matches('\n').count(), 1 + before[line_start..].chars().count())
    }
}

/// One thing that is wrong with a graph.
#[derive(Clone, Debug)]
pub struct DocumentError {
    source: Option<SourceText>,
    span: Option<Range<usize>>,
    message: String,
    label: Option<String>,
    help: Option<String>,
    node: Option<Box<str>>,
}

impl DocumentError {
    /// An error about no place in a file, such as a refused override.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self { source: None, span: None, message: message.into(), label: None, help: None, node: None }
    }

    pub(crate) fn at(source: &SourceText, span: Option<Range<usize>>, message: impl Into<String>) -> Self {
        Self { source: Some(source.clone()), span, ..Self::new(message) }
    }

    /// With what would mend it.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// With `help` when there is one.
    #[must_use]
    pub(crate) fn maybe_help(self, help: Option<String>) -> Self {
        Self { help: help.or(self.help), ..self }
    }

    /// With words beside the marked text.
    #[must_use]
    pub(crate) fn label(self, label: impl Into<String>) -> Self {
        Self { label: Some(label.into()), ..self }
    }

    /// About a node, unless none is named.
    #[must_use]
    pub(crate) fn about(self, node: Option<&str>) -> Self {
        Self { node: node.map(Into::into).or(self.node), ..self }
    }

    /// The node of the outermost document that it is about; for what is wrong inside a subgraph the node that stands for
    /// it.
    #[must_use]
    pub fn node(&self) -> Option<&str> {
        self.node.as_deref()
    }

    /// The file, as it was named when it was read.
    #[must_use]
    pub fn path(&self) -> Option<&str> {
        self.source.as_ref().map(SourceText::path)
    }

    /// The bytes of the file that it is about.
    #[must_use]
    pub fn span(&self) -> Option<Range<usize>> {
        self.span.clone()
    }

    /// The line, from 1.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.position().map(|(line, _)| line)
    }

    /// The column in characters, from 1.
    #[must_use]
    pub fn column(&self) -> Option<usize> {
        self.position().map(|(_, column)| column)
    }

    /// The text of that line, without its end.
    #[must_use]
    pub fn line_text(&self) -> Option<&str> {
        self.source.as_ref()?.text().split('\n').nth(self.line()? - 1)
    }

    fn position(&self) -> Option<(usize, usize)> {
        Some(self.source.as_ref()?.position(self.span.as_ref()?.start))
    }

    /// What is wrong, without its place.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What would mend it.
    #[must_use]
    pub fn help_text(&self) -> Option<&str> {
        self.help.as_deref()
    }
}

impl fmt::Display for DocumentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.path(), self.position()) {
            (Some(path), Some((line, column))) => write!(f, "{path}:{line}:{column}: {}", self.message),
            (Some(path), None) => write!(f, "{path}: {}", self.message),
            (None, _) => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for DocumentError {}

impl Diagnostic for DocumentError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| &*source.0 as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.span.clone()?;
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(self.label.clone(), span))))
    }
}

/// Everything that is wrong with a graph, up to [`DocumentErrors::MOST`].
#[derive(Clone, Debug)]
pub struct DocumentErrors(Vec<DocumentError>);

impl DocumentErrors {
    /// How many are told at once.
    pub const MOST: usize = 20;

    /// The errors file by file, each from its start; those about no file come first.
    pub(crate) fn new(mut errors: Vec<DocumentError>) -> Self {
        let mut paths: Vec<Option<String>> = vec![None];
        for error in &errors {
            if !paths.iter().any(|path| path.as_deref() == error.path()) {
                paths.push(error.path().map(str::to_owned));
            }
        }
        errors.sort_by_key(|error| {
            let file = paths.iter().position(|path| path.as_deref() == error.path());
            (file, error.span.as_ref().map(|span| span.start))
        });
        errors.truncate(Self::MOST);
        Self(errors)
    }

    /// The errors file by file, from the start of each.
    #[must_use]
    pub fn errors(&self) -> &[DocumentError] {
        &self.0
    }

    pub(crate) fn into_vec(self) -> Vec<DocumentError> {
        self.0
    }
}

impl From<DocumentError> for DocumentErrors {
    fn from(error: DocumentError) -> Self {
        Self(vec![error])
    }
}

impl fmt::Display for DocumentErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{error}")?;
        }
        Ok(())
    }
}

impl std::error::Error for DocumentErrors {}

impl Diagnostic for DocumentErrors {
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.0.iter().map(|error| error as &dyn Diagnostic)))
    }
}

//! RON with the place of every value.
//!
//! The `ron` crate tells no places of nested values and stops at the first error, and messages here need
//! both. So this module finds where values begin and end, and `ron` reads what a single string or number
//! means.

use std::ops::Range;

/// Deeper nesting than any graph has; keeps the reader's recursion off the end of the stack.
const MAX_DEPTH: usize = 64;
/// Bounds the memory that a hostile file can ask for.
const MAX_VALUES: usize = 2_000_000;

/// A value and the bytes that it covers.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) span: Range<usize>,
    pub(crate) shape: Shape,
}

/// What a value looks like.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    /// A string, without quotes and escapes.
    Text(String),
    /// A bare identifier.
    Word,
    /// Digits, with or without sign, point and exponent.
    Number,
    /// `[a, b]`
    List(Vec<Tree>),
    /// `(a, b)`
    Tuple(Vec<Tree>),
    /// `(a: 1, b: 2)`
    Fields(Vec<Entry>),
    /// `{a: 1, b: 2}`
    Map(Vec<Entry>),
    /// Valid RON that graph files do not use: characters, byte strings, named groups.
    Other,
}

/// A key with its value.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: Tree,
    pub(crate) value: Tree,
}

/// Where the text stops being RON, and what was expected there.
#[derive(Debug)]
pub(crate) struct SyntaxError {
    pub(crate) span: Range<usize>,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

impl Tree {
    /// The key or name that this is, when it is one.
    pub(crate) fn name<'a>(&'a self, text: &'a str) -> Option<&'a str> {
        match &self.shape {
            Shape::Text(name) => Some(name),
            Shape::Word => Some(&text[self.span.clone()]),
            _ => None,
        }
    }

    /// The entries of a struct or map.
    pub(crate) fn entries(&self) -> Option<&[Entry]> {
        match &self.shape {
            Shape::Fields(entries) | Shape::Map(entries) => Some(entries),
            Shape::Tuple(items) if items.is_empty() => Some(&[]),
            _ => None,
        }
    }

    /// What this is, for messages.
    pub(crate) fn noun(&self) -> &'static str {
        match self.shape {
            Shape::Text(_) => "a string",
            Shape::Word => "a bare word",
            Shape::Number => "a number",
            Shape::List(_) => "a list",
            Shape::Tuple(_) => "a tuple",
            Shape::Fields(_) => "a group of fields",
            Shape::Map(_) => "a map",
            Shape::Other => "another kind of value",
        }
    }
}

/// A file's value, and what stands beside it.
pub(crate) struct Parsed {
    pub(crate) tree: Tree,
    /// There are comments inside the value or after it.
    pub(crate) has_inner_comments: bool,
}

/// Whether `text` is white space and comments alone.
pub(crate) fn is_space(text: &str) -> bool {
    let mut reader = Reader { text, at: 0, values: 0, comments: 0 };
    reader.skip_space().is_ok() && reader.rest().is_empty()
}

/// Reads one value that fills the whole text.
pub(crate) fn read(text: &str) -> Result<Tree, SyntaxError> {
    parse(text).map(|parsed| parsed.tree)
}

/// As [`read`], telling of comments, too.
pub(crate) fn parse(text: &str) -> Result<Parsed, SyntaxError> {
    let mut reader = Reader { text, at: 0, values: 0, comments: 0 };
    reader.skip_space()?;
    reader.comments = 0;
    if reader.rest().is_empty() {
        return Err(reader.expected("a graph", Some("the file is empty")));
    }
    if reader.rest().starts_with("#!") {
        return Err(reader.expected("`(`", Some("graph files use no RON extensions; leave them out")));
    }
    let tree = reader.value(0)?;
    reader.skip_space()?;
    if !reader.rest().is_empty() {
        return Err(reader.expected("the end of the file after the closing bracket", None));
    }
    Ok(Parsed { tree, has_inner_comments: reader.comments > 0 })
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    values: usize,
    /// Comments passed over so far; one that is looked at twice counts twice.
    comments: usize,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn eat(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
        found
    }

    fn error(&self, start: usize, message: impl Into<String>, help: Option<&str>) -> SyntaxError {
        SyntaxError { span: start..self.at.max(start), message: message.into(), help: help.map(Into::into) }
    }

    fn expected(&self, what: &str, help: Option<&str>) -> SyntaxError {
        let (found, len) = match self.peek() {
            Some(c) => (format!("`{}`", c.escape_debug()), c.len_utf8()),
            None => ("the end of the file".to_owned(), 0),
        };
        SyntaxError {
            span: self.at..self.at + len,
            message: format!("expected {what}, found {found}"),
            help: help.map(Into::into),
        }
    }

    /// Skips white space and comments; block comments nest.
    fn skip_space(&mut self) -> Result<(), SyntaxError> {
        loop {
            let rest = self.rest();
            let trimmed = rest.trim_start();
            self.at += rest.len() - trimmed.len();
            if trimmed.starts_with("//") {
                self.at += trimmed.find('\n').unwrap_or(trimmed.len());
                self.comments += 1;
            } else if trimmed.starts_with("/*") {
                self.skip_block_comment()?;
                self.comments += 1;
            } else {
                return Ok(());
            }
        }
    }

    fn skip_block_comment(&mut self) -> Result<(), SyntaxError> {
        let start = self.at;
        let bytes = self.text.as_bytes();
        let mut depth = 0_usize;
        loop {
            match bytes.get(self.at..self.at + 2) {
                Some(b"/*") => (depth, self.at) = (depth + 1, self.at + 2),
                Some(b"*/") => (depth, self.at) = (depth - 1, self.at + 2),
                Some(_) => self.at += 1,
                None => {
                    self.at = start + 2;
                    return Err(self.error(start, "this comment has no end", Some("close it with `*/`")));
                }
            }
            if depth == 0 {
                return Ok(());
            }
        }
    }

    fn value(&mut self, depth: usize) -> Result<Tree, SyntaxError> {
        self.values += 1;
        if self.values > MAX_VALUES {
            let help = "keep big data in a file of its own and read it with a node";
            return Err(self.error(self.at, format!("more than {MAX_VALUES} values"), Some(help)));
        }
        if depth > MAX_DEPTH {
            let message = format!("brackets nest deeper than {MAX_DEPTH} levels");
            return Err(self.error(self.at, message, Some("no graph needs that; check the brackets")));
        }
        let start = self.at;
        let shape = match self.peek() {
            Some('(') => self.group(depth)?,
            Some('[') => {
                self.at += 1;
                Shape::List(self.items(']', depth)?)
            }
            Some('{') => {
                self.at += 1;
                Shape::Map(self.entries('}', depth)?)
            }
            Some('"') => self.string()?,
            Some('\'') => self.character()?,
            Some(c) if c.is_ascii_digit() || matches!(c, '+' | '-' | '.') => {
                self.number();
                Shape::Number
            }
            Some(c) if c.is_alphabetic() || c == '_' => self.word(depth)?,
            _ => return Err(self.expected("a value", None)),
        };
        Ok(Tree { span: start..self.at, shape })
    }

    /// After `(`: fields when the first item is an identifier with a colon, otherwise a tuple.
    fn group(&mut self, depth: usize) -> Result<Shape, SyntaxError> {
        self.at += 1;
        self.skip_space()?;
        let start = self.at;
        let is_fields = self.peek().is_some_and(|c| c.is_alphabetic() || c == '_') && {
            self.identifier();
            self.skip_space()?;
            self.peek() == Some(':')
        };
        self.at = start;
        if is_fields {
            Ok(Shape::Fields(self.entries(')', depth)?))
        } else {
            Ok(Shape::Tuple(self.items(')', depth)?))
        }
    }

    fn items(&mut self, close: char, depth: usize) -> Result<Vec<Tree>, SyntaxError> {
        let mut items = Vec::new();
        loop {
            self.skip_space()?;
            if self.eat(close) {
                return Ok(items);
            }
            items.push(self.value(depth + 1)?);
            self.separator(close)?;
        }
    }

    fn entries(&mut self, close: char, depth: usize) -> Result<Vec<Entry>, SyntaxError> {
        let mut entries = Vec::new();
        loop {
            self.skip_space()?;
            if self.eat(close) {
                return Ok(entries);
            }
            let key = self.value(depth + 1)?;
            self.skip_space()?;
            if !self.eat(':') {
                return Err(self.expected("`:` after the key", None));
            }
            self.skip_space()?;
            let value = self.value(depth + 1)?;
            entries.push(Entry { key, value });
            self.separator(close)?;
        }
    }

    fn separator(&mut self, close: char) -> Result<(), SyntaxError> {
        self.skip_space()?;
        if self.eat(',') || self.peek() == Some(close) {
            return Ok(());
        }
        Err(self.expected(&format!("`,` or `{close}`"), None))
    }

    fn identifier(&mut self) {
        let rest = self.rest();
        self.at += rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
    }

    fn number(&mut self) {
        let bytes = self.text.as_bytes();
        let start = self.at;
        while let Some(&byte) = bytes.get(self.at) {
            let sign = matches!(byte, b'+' | b'-');
            let after_exponent = self.at > start && matches!(bytes[self.at - 1], b'e' | b'E');
            if byte.is_ascii_alphanumeric()
                || matches!(byte, b'_' | b'.')
                || sign && (self.at == start || after_exponent)
            {
                self.at += 1;
            } else {
                break;
            }
        }
    }

    /// A bare word, a raw or byte string, or a named group.
    fn word(&mut self, depth: usize) -> Result<Shape, SyntaxError> {
        let start = self.at;
        let rest = self.rest();
        if let Some(quoted) = rest.strip_prefix('r')
            && quoted.trim_start_matches('#').starts_with('"')
        {
            return self.raw_string();
        }
        if rest.starts_with("b\"") {
            self.at += 1;
            self.skip_quoted('"')?;
            return Ok(Shape::Other);
        }
        if rest.starts_with("b'") {
            self.at += 1;
            return self.character();
        }
        self.identifier();
        let end = self.at;
        self.skip_space()?;
        if self.peek() == Some('(') {
            let inner = self.value(depth + 1)?;
            self.at = inner.span.end;
            return Ok(Shape::Other);
        }
        self.at = end;
        debug_assert!(end > start);
        Ok(Shape::Word)
    }

    fn string(&mut self) -> Result<Shape, SyntaxError> {
        let start = self.at;
        self.skip_quoted('"')?;
        ron::from_str(&self.text[start..self.at]).map(Shape::Text).map_err(|error| {
            self.error(
                start,
                format!("this string is not valid: {}", error.code),
                Some("write `\\\\` for a backslash"),
            )
        })
    }

    fn raw_string(&mut self) -> Result<Shape, SyntaxError> {
        let start = self.at;
        let hashes = self.rest()[1..].bytes().take_while(|byte| *byte == b'#').count();
        let close = format!("\"{}", "#".repeat(hashes));
        let content = start + 2 + hashes;
        match self.text[content..].find(&close) {
            Some(len) => {
                self.at = content + len + close.len();
                Ok(Shape::Text(self.text[content..content + len].to_owned()))
            }
            None => Err(self.error(start, "this string has no end", Some("close it with the same quotes"))),
        }
    }

    fn character(&mut self) -> Result<Shape, SyntaxError> {
        self.skip_quoted('\'')?;
        Ok(Shape::Other)
    }

    fn skip_quoted(&mut self, quote: char) -> Result<(), SyntaxError> {
        let start = self.at;
        self.at += quote.len_utf8();
        let mut escaped = false;
        for (offset, c) in self.text[self.at..].char_indices() {
            if escaped {
                escaped = false;
            } else if c == '\\' {
                escaped = true;
            } else if c == quote {
                self.at += offset + c.len_utf8();
                return Ok(());
            }
        }
        Err(self.error(start, "this string has no end", Some("close it with the same quote")))
    }
}

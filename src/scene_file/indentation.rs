//! What the indentation of a scene says about a missing brace. The grammar itself has no lines.

use super::fields::Fields;
use super::lexer::{Lexer, Token};

impl<'a> Fields<'a> {
    /// Returns what is missing before byte `end`, as messages name it.
    pub fn missing_brace(&self, end: usize) -> String {
        format!("'}}' to end {}", self.unended(end).map_or(String::new(), |block| self.named(block)))
    }

    /// Returns the block that has no `}` before byte `end`, as far as the indentation tells: the innermost open one, or one
    /// in it that ends with a `}` under the name of a block around it.
    pub fn unended(&self, end: usize) -> Option<Token<'a>> {
        let innermost = *self.open.last()?;
        let mut before = innermost;
        let mut open: Vec<Token> = Vec::new();
        let mut found: Option<Token> = None;
        for token in Lexer::new(&self.source.text[..end]).skip_while(|token| *token != innermost) {
            match token.text {
                "{" => open.push(before),
                "}" => {
                    let block = open.pop().unwrap_or(innermost);
                    let is_under = |block: &Token| self.is_under(token.span.start, *block);
                    if is_under(&block) {
                        // What stands in it has its braces, then.
                        found = found.filter(|other| other.span.start < block.span.start);
                    } else if open.iter().any(is_under) {
                        found = found.or(Some(block));
                    }
                }
                _ => {}
            }
            before = token;
        }
        found.or(Some(innermost))
    }

    /// Returns whether the word at byte `at` is as far to the right as the name of a block, each the first word of its line.
    fn is_under(&self, at: usize, block: Token) -> bool {
        self.indentation(at).is_some_and(|blanks| self.indentation(block.span.start) == Some(blanks))
    }

    /// Returns whether the word at byte `at` is under the name of a block or left of it, each the first word of its line,
    /// and what stands before the word is not: without indentation nothing tells.
    pub fn is_outside(&self, at: usize, block: Token) -> bool {
        let before = Lexer::new(&self.source.text[..at]).last().map_or(0, |token| token.span.start);
        let blanks = self.line_before(before).chars().take_while(|&c| is_blank(c)).count();
        let of_word = self.indentation(at);
        let is_left = |of_block: &str| of_word.is_some_and(|of_word| of_block.starts_with(of_word));
        self.indentation(block.span.start).is_some_and(|of_block| is_left(of_block) && blanks > of_block.len())
    }

    /// Returns the blanks before the word at byte `at`, if it is the first one of its line.
    fn indentation(&self, at: usize) -> Option<&str> {
        Some(self.line_before(at)).filter(|text| text.chars().all(is_blank))
    }

    /// Returns what stands before byte `at` in its line.
    fn line_before(&self, at: usize) -> &str {
        let text = &self.source.text[..at];
        &text[text.rfind('\n').map_or(0, |end| end + 1)..]
    }
}

fn is_blank(c: char) -> bool {
    matches!(c, ' ' | '\t')
}

//! [`Remarks`]: what a user should know about a run that goes on.

/// Warnings and hints, a sentence each.
#[derive(Debug, Default)]
pub struct Remarks {
    /// A picture is not what the scene says, or may be wrong.
    pub warnings: Vec<String>,
    /// The picture is right, and something about it may surprise.
    pub hints: Vec<String>,
}

impl Remarks {
    /// Adds further remarks behind these.
    pub fn add(&mut self, others: Self) {
        self.warnings.extend(others.warnings);
        self.hints.extend(others.hints);
    }

    /// Iterates over the lines to print: with `quiet` the warnings only.
    pub fn lines(&self, quiet: bool) -> impl Iterator<Item = String> {
        let warnings = self.warnings.iter().map(|text| format!("warning: {text}\n"));
        let hints = self.hints.iter().filter(move |_| !quiet).map(|text| format!("hint: {text}\n"));
        warnings.chain(hints)
    }
}

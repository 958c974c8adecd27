//! README.md and README.zh.md say the same: the same commands, tables of the same size, the same links.

use crate::support::project;

fn text(name: &str) -> String {
    std::fs::read_to_string(project(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// What must be equal in every language.
#[derive(Debug, Default, PartialEq)]
struct Structure {
    /// Levels of the headings, in order.
    headings: Vec<usize>,
    /// Lines of the code blocks, without comments.
    code: Vec<String>,
    /// Of each row of a table, the number of cells, and what stands in backquotes in the first one.
    rows: Vec<(usize, Vec<String>)>,
    /// Targets of links and pictures, sorted, without those to a heading of the same page or to the other language.
    links: Vec<String>,
}

fn structure(text: &str) -> Structure {
    let mut found = Structure::default();
    let mut is_code = false;
    for line in text.lines() {
        if line.starts_with("```") {
            is_code = !is_code;
            found.code.push(line.to_owned());
            continue;
        }
        if is_code {
            let code = line.split(" # ").next().unwrap();
            found.code.push(code.trim_end().to_owned());
            continue;
        }
        if line.starts_with('#') {
            found.headings.push(line.chars().take_while(|c| *c == '#').count());
        }
        if line.starts_with('|') {
            let cells: Vec<&str> = line.split('|').collect();
            let names = cells[1].split('`').skip(1).step_by(2).map(str::to_owned).collect();
            found.rows.push((cells.len(), names));
        }
        let targets = line.split("](").skip(1).map(|rest| rest.split(')').next().unwrap().to_owned());
        found.links.extend(targets.filter(|target| !target.starts_with('#') && !target.starts_with("README")));
    }
    found.links.sort();
    found
}

#[test]
fn both_languages_say_the_same() {
    let (english, chinese) = (structure(&text("README.md")), structure(&text("README.zh.md")));
    assert!(english.rows.len() > 40 && english.code.len() > 30 && english.links.len() > 20, "{english:?}");
    const HINT: &str = "what changes in README.md changes in README.zh.md, too";
    assert_eq!(chinese.headings, english.headings, "{HINT}");
    assert_eq!(chinese.code, english.code, "{HINT}");
    assert_eq!(chinese.rows, english.rows, "{HINT}");
    assert_eq!(chinese.links, english.links, "{HINT}");
}

/// The figures that `scripts/readme_figures.py` writes are the same, too: those of the table, and the ratios to the peers in
/// the line below it.
#[test]
fn both_languages_have_the_same_figures() {
    let figures = |name: &str| {
        let text = text(name);
        let (_, rest) = text.split_once("<!-- figures: begin -->").unwrap();
        let rows = rest.lines().filter(|line| line.starts_with("| 0")).map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            cells[3..].join(" ")
        });
        rows.collect::<Vec<_>>()
    };
    assert_eq!(figures("README.md").len(), 7);
    assert_eq!(figures("README.zh.md"), figures("README.md"));
    let ratios = |name: &str| {
        let text = text(name);
        let line = text.split_once("\n<!-- figures: end -->").unwrap().0.lines().last().unwrap();
        let words = line.split(|c: char| !c.is_ascii_digit() && c != '.' && c != ',');
        let numbers = words.map(|word| word.trim_matches(['.', ',']).to_owned()).filter(|word| !word.is_empty());
        numbers.collect::<Vec<_>>()
    };
    assert!(ratios("README.md").len() >= 7, "{:?}", ratios("README.md"));
    assert_eq!(ratios("README.zh.md"), ratios("README.md"));
}

#[test]
fn links_of_both_lead_to_files() {
    for name in ["README.md", "README.zh.md"] {
        for link in structure(&text(name)).links.iter().filter(|link| !link.starts_with("http")) {
            let path = link.split('#').next().unwrap();
            assert!(project(path).exists(), "{name}: there is no {path}");
        }
    }
}

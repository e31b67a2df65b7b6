//! What terminal widgets draw, as plain text: for pipes, files and tests.

use std::io::{self, IsTerminal};

use ratatui::buffer::Buffer;

/// Columns of text that goes to no terminal.
pub const COLUMNS: u16 = 100;

/// The columns that standard output has.
pub fn columns() -> u16 {
    if !io::stdout().is_terminal() {
        return COLUMNS;
    }
    ratatui::crossterm::terminal::size().map_or(COLUMNS, |(columns, _)| columns)
}

/// The characters of a buffer, line by line, without their colours.
pub fn of(buffer: &Buffer) -> String {
    let area = buffer.area;
    let mut text = String::new();
    for row in area.rows() {
        let line: String =
            row.columns().filter_map(|cell| buffer.cell(cell.as_position())).map(|cell| cell.symbol()).collect();
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;

    #[test]
    fn lines_end_where_their_text_does() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 10, 3));
        buffer.set_string(2, 0, "a⣿b", ratatui::style::Style::new());
        buffer.set_string(0, 2, "c", ratatui::style::Style::new());
        assert_eq!(of(&buffer), "  a⣿b\n\nc\n");
    }
}

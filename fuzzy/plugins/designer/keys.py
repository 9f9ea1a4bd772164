"""The keys of the designer's page, as its help lists them."""

# (key, where, what it does); docs/howto/designer.md has the same table.
SHORTCUTS = (
    ("?", "everywhere but in a field", "this list"),
    ("Ctrl+S; Ctrl+Z; Ctrl+Shift+Z or Ctrl+Y", "everywhere", "save; undo; redo (⌘ on a Mac)"),
    ("Tab, Shift+Tab", "everywhere", "the next control, the one before"),
    ("← →, Home, End", "tabs of the views", "another view"),
    ("← → ↑ ↓", "a handle, marker, red line, number field", "1/200 of the range; with Shift ten times that"),
    ("Page up, Page down; Home, End", "the same", "ten steps; the ends of the range (fields: only Page up, Page down)"),
    ("Alt with an arrow", "a handle of a curve", "moves the whole curve"),
    ("← →, Home, End; Enter", "a picture of measured rows", "another row (with Shift ten further); the viewer there"),
    ("Escape", "while dragging", "back to where it began"),
    ("Enter; Escape", "a sentence, a field", "accepts it; gives the last good one back"),
    ("Alt+↑, Alt+↓", "a rule", "moves it, with all that are selected"),
    ("Ctrl+A", "the list of rules", "selects all that are shown (in a sentence its text first)"),
    ("↑ ↓, with Shift; Delete; Escape", "the box before a rule", "another rule, all between; deletes, deselects"),
    ("← → ↑ ↓, Home, End, Page up, Page down", "the rule matrix", "another cell; with Shift a range, Ctrl+A all"),
    ("a letter; Enter; Delete", "the rule matrix", "chooses a consequent; fills the selected cells; clears them"),
    ("← → ↑ ↓", "the 3-D surface", "turns it; with Shift faster"),
    ("↑ ↓ ← →, Home, End", "the tree", "walks, opens and closes"),
    ("Enter or Space; Delete", "the tree", "chooses a variable or term; removes it, in the rules too"),
    ("↑ ↓, Home, End; Enter", "the list of edits", "walks; goes to that edit"),
    ("Space; ← →, Home, End", "the time of a run, the strip of rules", "play or pause; earlier and later, the ends"),
    ("Space; ← →, with Shift; N, P", "the player", "play or pause; 1 s, 10 s; next and previous change of mode"),
)

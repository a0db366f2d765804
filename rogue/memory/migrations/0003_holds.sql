-- Errands that are put off: the room that could not be served, until when, for what trouble, and
-- why in words.
CREATE TABLE holds (
    request TEXT PRIMARY KEY REFERENCES requests (id),
    room TEXT NOT NULL,
    until REAL NOT NULL,
    trouble TEXT NOT NULL,
    reason TEXT NOT NULL
) WITHOUT ROWID;

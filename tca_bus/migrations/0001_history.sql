-- What happened to the task tree, in order. "root" is the top-level task above "task".
CREATE TABLE events (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    time REAL NOT NULL,
    root TEXT NOT NULL,
    task TEXT NOT NULL,
    name TEXT NOT NULL,
    kind TEXT NOT NULL,
    body TEXT NOT NULL
);
CREATE INDEX events_of_root ON events (root, number);
CREATE INDEX events_of_task ON events (task, number);

-- Top-level tasks; those with an end are not replayed.
CREATE TABLE roots (
    root TEXT PRIMARY KEY,
    ended REAL
);
CREATE INDEX roots_by_end ON roots (ended);

-- The last status of each node of a top-level task that ended.
CREATE TABLE tasks (
    task TEXT PRIMARY KEY,
    root TEXT NOT NULL,
    number INTEGER NOT NULL,
    status TEXT NOT NULL
);
CREATE INDEX tasks_of_root ON tasks (root, number);

-- How often central was started on this journal.
CREATE TABLE starts (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    time REAL NOT NULL
);

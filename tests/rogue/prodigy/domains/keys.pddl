(define (domain keys)
  (:requirements :strips :typing)
  (:types cell key shape)
  (:predicates (beside ?a ?b - cell) (me-at ?c - cell) (unlocked ?c - cell) (hand-free)
               (key-at ?k - key ?c - cell) (have ?k - key)
               (lock-shape ?c - cell ?s - shape) (key-shape ?k - key ?s - shape))
  (:action walk
    :parameters (?to ?from - cell)
    :precondition (and (beside ?from ?to) (me-at ?from) (unlocked ?to))
    :effect (and (not (me-at ?from)) (me-at ?to)))
  (:action take
    :parameters (?key - key ?cell - cell)
    :precondition (and (key-at ?key ?cell) (me-at ?cell) (hand-free))
    :effect (and (not (key-at ?key ?cell)) (not (hand-free)) (have ?key)))
  (:action lay-down
    :parameters (?key - key ?cell - cell)
    :precondition (and (have ?key) (me-at ?cell))
    :effect (and (key-at ?key ?cell) (hand-free) (not (have ?key))))
  (:action unlock
    :parameters (?cell ?from - cell ?shape - shape ?key - key)
    :precondition (and (lock-shape ?cell ?shape) (key-shape ?key ?shape) (beside ?from ?cell)
                       (have ?key) (me-at ?from))
    :effect (unlocked ?cell)))

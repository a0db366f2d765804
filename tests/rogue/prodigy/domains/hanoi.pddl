(define (domain hanoi)
  (:requirements :strips :typing :equality :negative-preconditions)
  (:types disc peg - thing)
  (:predicates (smaller ?d - disc ?t - thing) (on ?d - disc ?t - thing) (clear ?t - thing))
  (:action move
    :parameters (?disc - disc ?to ?from - thing)
    :precondition (and (smaller ?disc ?to) (on ?disc ?from) (clear ?disc) (clear ?to)
                       (not (= ?disc ?to)) (not (= ?from ?to)))
    :effect (and (not (on ?disc ?from)) (not (clear ?to)) (on ?disc ?to) (clear ?from))))

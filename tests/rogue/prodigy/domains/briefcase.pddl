(define (domain briefcase)
  (:requirements :strips :typing :equality :negative-preconditions :conditional-effects
                 :quantified-preconditions)
  (:types portable place)
  (:predicates (at ?thing - portable ?place - place) (case-at ?place - place)
               (inside ?thing - portable))
  (:action carry
    :parameters (?to ?from - place)
    :precondition (and (case-at ?from) (not (= ?from ?to)))
    :effect (and (not (case-at ?from)) (case-at ?to)
                 (forall (?thing - portable)
                   (when (inside ?thing) (and (not (at ?thing ?from)) (at ?thing ?to))))))
  (:action put-in
    :parameters (?thing - portable ?place - place)
    :precondition (and (at ?thing ?place) (case-at ?place) (not (inside ?thing)))
    :effect (inside ?thing))
  (:action take-out
    :parameters (?thing - portable)
    :precondition (inside ?thing)
    :effect (not (inside ?thing))))

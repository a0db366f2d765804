; Four-operator blocks world.
(define (domain blocks)
  (:requirements :strips :typing :equality :negative-preconditions)
  (:types object)
  (:predicates (clear ?b) (on-table ?b) (arm-empty) (holding ?b) (on ?b ?under))
  (:action pick-up
    :parameters (?ob)
    :precondition (and (clear ?ob) (on-table ?ob) (arm-empty))
    :effect (and (not (on-table ?ob)) (not (clear ?ob)) (not (arm-empty)) (holding ?ob)))
  (:action put-down
    :parameters (?ob)
    :precondition (holding ?ob)
    :effect (and (not (holding ?ob)) (clear ?ob) (arm-empty) (on-table ?ob)))
  (:action stack
    :parameters (?ob ?under)
    :precondition (and (clear ?under) (holding ?ob) (not (= ?ob ?under)))
    :effect (and (not (holding ?ob)) (not (clear ?under)) (arm-empty) (clear ?ob) (on ?ob ?under)))
  (:action unstack
    :parameters (?ob ?under)
    :precondition (and (on ?ob ?under) (clear ?ob) (arm-empty) (not (= ?ob ?under)))
    :effect (and (not (on ?ob ?under)) (not (clear ?ob)) (not (arm-empty))
                 (holding ?ob) (clear ?under))))

"""The published traces, byte for byte."""

from __future__ import annotations

FIGURE6 = """\
  2 n2 (done)
  4 n4 <*finish*>
  5   n5 (has-item mitchell delivermail)
  7   n7 <deliver-item r-5313 mitchell delivermail>
  8     n8 (robot-has-item mitchell delivermail)
 10     n10 <acquire-item r-5303 mitchell delivermail>
 11       n11 (robot-in-room r-5303)
 13       n13 <goto-pickup-loc mitchell r-5303>
 14     n14 (robot-in-room r-5313)
 15     n15 goto-pickup-loc ...no choices for bindings (I tried)
 16     n17 <goto-deliver-loc mitchell r-5313>
 17       n18 <GOTO-PICKUP-LOC MITCHELL R-5303>
 18     n19 <ACQUIRE-ITEM R-5303 MITCHELL DELIVERMAIL>
 19     n20 <GOTO-DELIVER-LOC MITCHELL R-5313>
 19   n21 <DELIVER-ITEM R-5313 MITCHELL DELIVERMAIL>
Achieved top-level goals.
"""

FIGURE9 = """\
  2 n2 (done)
  4 n4 <*finish*>
  5   n5 (has-item mitchell delivermail)
  7   n7 <deliver-item r-5313 mitchell delivermail>
  8     n8 (robot-has-item mitchell delivermail)
 10     n10 <acquire-item r-5303 mitchell delivermail>
 11       n11 (robot-in-room r-5303)
 13       n13 <goto-pickup-loc mitchell r-5303>
 14     n14 (robot-in-room r-5313)
 15     n15 goto-pickup-loc ...no choices for bindings (I tried)
 16     n17 <goto-deliver-loc mitchell r-5313>
 17       n18 <GOTO-PICKUP-LOC MITCHELL R-5303>
 18     n19 <ACQUIRE-ITEM R-5303 MITCHELL DELIVERMAIL>
 19   n20 (has-item jhm deliverfax)
 21   n22 <deliver-item r-5313 jhm deliverfax>
 22     n23 (robot-has-item jhm deliverfax)
 24     n25 <acquire-item r-5311 jhm deliverfax>
 25       n26 (robot-in-room r-5311)
 27       n28 <goto-pickup-loc jhm r-5311>
 28       n29 <GOTO-PICKUP-LOC JHM R-5311>
 29     n30 <ACQUIRE-ITEM R-5311 JHM DELIVERFAX>
 30     n31 <GOTO-DELIVER-LOC MITCHELL R-5313>
 31   n32 <DELIVER-ITEM R-5313 JHM DELIVERFAX>
 31   n33 <DELIVER-ITEM R-5313 MITCHELL DELIVERMAIL>
Achieved top-level goals.
"""

EXAMPLE1998 = """\
  2 n2 (done)
  4 n4 <*finish*>
  5   n5 (has-item mitchell delivermail)
  7   n7 <deliver-item r-5313 mitchell delivermail>
  8     n8 (robot-has-item mitchell delivermail)
 10     n10 <acquire-item r-5303 mitchell delivermail>
 11       n11 (robot-in-room r-5303)
 13       n13 <goto-pickup-loc mitchell r-5303>
 14     n14 (robot-in-room r-5313)
 16     n16 <goto-deliver-loc mitchell r-5313>
 17       n17 <GOTO-PICKUP-LOC MITCHELL R-5303>
 18   n18 (has-item jhm deliverfax)
 20   n20 <deliver-item r-5313 jhm deliverfax>
 21     n21 (robot-has-item jhm deliverfax)
 23     n23 <acquire-item r-5311 jhm deliverfax>
 24       n24 (robot-in-room r-5311)
 26       n26 <goto-pickup-loc jhm r-5311>
 27     n27 <ACQUIRE-ITEM R-5303 MITCHELL DELIVERMAIL>
 28       n28 <GOTO-PICKUP-LOC JHM R-5311>
 29     n29 <ACQUIRE-ITEM R-5311 JHM DELIVERFAX>
 30     n30 <GOTO-DELIVER-LOC MITCHELL R-5313>
 31   n31 <DELIVER-ITEM R-5313 JHM DELIVERFAX>
 31   n32 <DELIVER-ITEM R-5313 MITCHELL DELIVERMAIL>
Achieved top-level goals.
"""

"""The style sheet of the drawings, for light and dark pages."""

STYLE = """
svg { background: #ffffff; }
text { font: 13px ui-sans-serif, system-ui, "Helvetica Neue", Arial, sans-serif; fill: #1b1f24; }
.title { font-size: 17px; font-weight: 600; }
.fact { fill: #424a53; }
.warning { fill: #b42318; font-weight: 600; }
.frame { fill: none; stroke: #d0d7de; }
.ground { fill: #e7eaee; }
.space { fill: #ffffff; }
.open-space { fill: #f4f8fc; }
.wall { fill: none; stroke: #3d444d; stroke-width: 1.2; stroke-linecap: round; }
.near-wall { fill: none; stroke: #3d444d; stroke-width: 2.6; stroke-linecap: round; }
.leaf { fill: none; stroke: #ffffff; stroke-width: 1.6; }
.shut { fill: none; stroke: #cf222e; stroke-width: 3.4; stroke-linecap: round; }
.room { font-size: 12px; fill: #8c959f; text-anchor: middle; }
.goal-room { fill: #1a6b2d; font-weight: 700; }
.cone { fill: #1f6feb; fill-opacity: 0.08; }
.echo { fill: none; stroke: #1f6feb; stroke-width: 2.2; stroke-linecap: round; }
.seen { fill: #bf3989; }
.silent { fill: none; stroke: #8c959f; stroke-width: 0.8; stroke-dasharray: 1 4; }
.cell { fill: #e8761c; }
.look { fill: none; stroke: #9a4a00; stroke-width: 2; stroke-linecap: round; }
.doubt { fill: none; stroke: #9a4a00; stroke-width: 1.4; stroke-dasharray: 4 3; }
.way { fill: none; stroke: #1a7f37; stroke-width: 2.4; stroke-linejoin: round;
  stroke-dasharray: 7 4; }
.goal { fill: #1a7f37; fill-opacity: 0.16; stroke: #1a7f37; stroke-width: 2; }
.goal-dot { fill: #1a7f37; }
.blocked { fill: #cf222e; fill-opacity: 0.18; stroke: #cf222e; }
.body { fill: #1b1f24; stroke: #ffffff; stroke-width: 1.2; }
.nose { fill: none; stroke: #ffffff; stroke-width: 2.2; stroke-linecap: round; }
.touch { fill: none; stroke: #cf222e; stroke-width: 5; }
.person { fill: #8250df; fill-opacity: 0.8; }
.thing { fill: #6e7781; fill-opacity: 0.8; }
.lens { fill: none; stroke: #57606a; stroke-width: 1; }
@media (prefers-color-scheme: dark) {
svg { background: #0d1117; }
text { fill: #e6edf3; }
.fact { fill: #b1bac4; }
.warning { fill: #ff7b72; }
.frame { stroke: #30363d; }
.ground { fill: #1c2129; }
.space { fill: #0d1117; }
.open-space { fill: #10161e; }
.wall, .near-wall { stroke: #b1bac4; }
.leaf { stroke: #0d1117; }
.shut { stroke: #ff7b72; }
.room { fill: #8b949e; }
.goal-room { fill: #56d364; }
.cone { fill: #58a6ff; fill-opacity: 0.1; }
.echo { stroke: #58a6ff; }
.seen { fill: #f778ba; }
.cell { fill: #f0883e; }
.look, .doubt { stroke: #ffc680; }
.way, .goal { stroke: #3fb950; }
.goal, .goal-dot { fill: #3fb950; }
.body { fill: #e6edf3; stroke: #0d1117; }
.person { fill: #a371f7; }
.thing { fill: #8b949e; }
.nose { stroke: #0d1117; }
.lens { stroke: #8b949e; }
}
"""

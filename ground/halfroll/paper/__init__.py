"""The paper, reproduced claim by claim: `halfroll paper`.

Why: its figures are the specification of everything else here, so each is made again by the code that flies, and its
numbers are compared with the paper's. One module a figure; docs/paper.md leads from equations to code.
"""

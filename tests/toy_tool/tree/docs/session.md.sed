/^### radius:/i\
### toy\
\
    {"tool": "toy", "center": [0, 1, 0], "push": [0, 0.2, 0], "outer": 0.5}\
\
Pushes what is in a ball once. `sharpness` (0.25) is the ratio of its inner to its outer radius.\


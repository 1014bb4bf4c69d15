0,/^- /s/^- /- A toy tool.\n- /

s|^\( *\)strokes/strain.cpp|&\n\1strokes/toy.cpp|

s/^\( *\)surface_point.cpp/&\n\1toy.cpp/

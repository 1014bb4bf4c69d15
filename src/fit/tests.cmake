knead_test(knead_fit_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/fit_test.cpp
           SLOW Fit.TurnsAndMovesTheSourceFirst Fit.GrowsAsAWholeWhereVolumesMayChange Fit.StartsFromAMap)

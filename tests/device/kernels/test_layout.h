// What the test kernels and the tests share.
CONST_INT(kTileSide, 8)
CONST_INT(kTileColumns, 64)
CONST_INT(kTileNeighbours, 9)  // a tile's neighbours row by row, itself in the middle
CONST_INT(kAbsent, -1)

// Adds to word `lane` of each buffer the number of the buffer, to show that names and bindings
// agree.

void touch_buffers(int group, int lane) {
    state[lane] += 1;
    delta[lane] += 2;
    tile_table[lane] += 3;
    block_list[lane] += 4;
    block_flags[lane] += 5;
    spans[lane] += 6;
    shapes[lane] += 7;
    tables[lane] += 8;
    result[lane] += 9 + group;
}

// Each lane at its own word, `stride` apart, in each of the ways in which a long buffer is reached.

void touch_long_buffer(int group, int lane) {
    int at = lane_index(group, lane) * params.stride;
    int before = marks_word(at);
    set_marks_word(at, before + 1);
    int added_to = add_to_marks(at, 10);
    int raised = raise_marks(at, 1000 + at);
    outputs[lane_index(group, lane)] = added_to * 4 + (raised == added_to + 10 ? 1 : 0);
}

int touch_long_buffer_lanes(int group, int half_at) { return kAllLanes; }

// Every word of the kernel language on a pair of integers. Reads inputs (pairs); writes outputs
// (planes of params.stride).

void split_halves(int value, OUT(int) low, INOUT(int) sum) {
    low = value & 65535;
    sum += value >> 16;
}

// Which bits a NaN has, and what a denormal number is, every device says for itself.
CONST_INT(kExponentBits, 0x7F800000)
bool is_number(int bits) { return (bits & kExponentBits) != kExponentBits; }
bool is_denormal(int bits) { return (bits & kExponentBits) == 0 && (bits & 0x7FFFFFFF) != 0; }

void probe_builtins(int group, int lane) {
    int i = lane_index(group, lane);
    int a = inputs[2 * i];
    int b = inputs[2 * i + 1];
    float x = int_as_float(is_number(a) ? a : 0);
    float y = int_as_float(is_number(b) && !is_denormal(b) ? b : 0);
    int stride = params.stride;
    outputs[i] = mul_q16(a, b);
    outputs[stride + i] = float_as_int(sqrt_exact(x));
    outputs[2 * stride + i] = float_as_int(inv_sqrt_exact(x));
    // Bounded, so that no device meets an infinite or denormal number.
    PRECISE float u = float(a >> 12) * 0.001f;
    PRECISE float v = float(b >> 12) * 0.37f;
    PRECISE float fused = u * v + u;
    fused = fused - v * v;
    outputs[3 * stride + i] = float_as_int(fused);
    vec3 offset = vec3(u, v, fused) * 0.5f;
    outputs[4 * stride + i] = int(floor(clamp(offset.x + offset.y, -1000.0f, 1000.0f)));
    ivec3 whole = clamp(ivec3(a >> 8, b >> 8, i), ivec3(-5000), ivec3(5000));
    int spread = min(whole.y, whole.z) - max(whole.x, whole.z);
    outputs[5 * stride + i] = abs(whole.x) + spread + sign(whole.y);
    int low = 0;
    int sum = b >> 16;
    split_halves(a, low, sum);
    outputs[6 * stride + i] = low + sum;
    outputs[7 * stride + i] = !is_denormal(a) && x < y ? 1 : 0;
    outputs[8 * stride + i] = float_as_int(divide_exact(u, v + (v < 0.0f ? -1.5f : 1.5f)));
    outputs[9 * stride + i] = 32 * bit_count(a) + (a == 0 ? 0 : lowest_bit(a));
    outputs[10 * stride + i] = square_root(a & 0x7FFFFFFF);
}

int probe_builtins_lanes(int group, int half_at) { return kAllLanes; }

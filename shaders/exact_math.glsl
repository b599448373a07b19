// Roots of floats out of + - * alone, with a fixed number of steps: the same bits on every device,
// which the built-in sqrt and division do not promise. And one of integers. C++ and GLSL read this text.

// Bits of 2^-96. Smaller arguments count as zero: their remainders could be denormal, which devices
// may flush.
CONST_INT(kExactRootMinBits, 0x0F800000)
// First guess of 1 / sqrt(x) from the bits of x, off by at most 3.5 %; a Newton step leaves 1.5
// times its square.
CONST_INT(kInvSqrtGuessBits, 0x5F375A86)
CONST_INT(kInvSqrtSteps, 3)

// 1 / sqrt(x), 2e-7 relative, for x in 2^-96 .. 2^126; 0 for smaller or negative x, so that scaling
// a zero vector by it gives a zero vector.
float inv_sqrt_exact(float x) {
    int bits = float_as_int(x);
    PRECISE float y = int_as_float(kInvSqrtGuessBits - (max(bits, 0) >> 1));
    for (int i = 0; i < kInvSqrtSteps; ++i) {
        // y += y (1 - x y^2) / 2, in an order in which nothing leaves the range of a float.
        PRECISE float xy = x * y;
        PRECISE float half_y = 0.5f * y;
        PRECISE float product = xy * half_y;
        PRECISE float remainder = 0.5f - product;
        PRECISE float correction = y * remainder;
        y = y + correction;
    }
    return bits < kExactRootMinBits ? 0.0f : y;  // at the end: loops over roots become vectors
}

// sqrt(x), 2e-7 relative, for x in 2^-96 .. 2^126; 0 for smaller or negative x.
float sqrt_exact(float x) {
    PRECISE float y = inv_sqrt_exact(x);
    PRECISE float root = x * y;
    PRECISE float square = root * root;
    PRECISE float remainder = x - square;
    PRECISE float half_y = 0.5f * y;
    PRECISE float correction = remainder * half_y;
    PRECISE float corrected = root + correction;
    return corrected;
}

// Two squares of smaller numbers stay in 31 bits together.
CONST_INT(kSquaredMost, 32768)

// Whole square root of a sum of squares of numbers below 2^29, to within 2^-12 of itself.
int slope_length(int a, int b) {
    int high = max(abs(a), abs(b));
    if (high == 0) return 0;
    int shift = 0;
    while (high >= kSquaredMost) {
        high = high >> 1;
        shift += 1;
    }
    int x = abs(a) >> shift;
    int y = abs(b) >> shift;
    return square_root(x * x + y * y) << shift;
}

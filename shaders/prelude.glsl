// Head of every kernel on OpenGL: the words of the common kernel language. RUNS_IN_SOFTWARE is defined where processors run it,
// eight lanes at a time: those divide floats together and integers one by one. The storage blocks of buffer_list.h, the uniform
// block of soil_params.h, exact_math.glsl and soil_layout.h follow it.
// Its C++ twin is plugin/src/device/cpu_shim.h; what one has, the other has, bit for bit.
layout(local_size_x = 64) in;

#define CONST_INT(name, value) const int name = value;
#define CONST_FLOAT(name, value) const float name = value;
#define IN(type) in type
#define OUT(type) out type
#define INOUT(type) inout type
// Marks a float whose every operation is rounded on its own, so that all devices agree on it.
#define PRECISE precise

// Each returns the value from before. Any group may touch the same word at the same time.
#define ATOMIC_ADD(word, value) atomicAdd(word, value)
#define ATOMIC_MAX(word, value) atomicMax(word, value)
#define ATOMIC_OR(word, value) atomicOr(word, value)
// A word that other groups change by ATOMIC_* in this same dispatch: some value it had.
#define ATOMIC_LOAD(word) (word)
// For words that on the CPU only one thread touches at a time (the voxels that a SCATTER kernel's
// tile reaches): atomic here, plain there.
#define ATOMIC_ADD_OWNED(word, value) atomicAdd(word, value)
#define ATOMIC_MAX_OWNED(word, value) atomicMax(word, value)
#define ATOMIC_MIN_OWNED(word, value) atomicMin(word, value)
#define ATOMIC_OR_OWNED(word, value) atomicOr(word, value)
#define ATOMIC_AND_OWNED(word, value) atomicAnd(word, value)

// Of <kernel>_lanes(group, half): 32 lanes, all of which have work.
CONST_INT(kAllLanes, -1)

int float_as_int(float x) { return floatBitsToInt(x); }
float int_as_float(int bits) { return intBitsToFloat(bits); }

// floor(a * b / 2^16), exact wherever the result fits into 32 bits.
int mul_q16(int a, int b) {
    int high, low;
    imulExtended(a, b, high, low);
    return (high << 16) | int(uint(low) >> 16);
}

// floor(65536 part / whole) for 0 <= part <= whole < 2^27.
#ifdef RUNS_IN_SOFTWARE
// A half is less than what the quotient lacks to the next whole number, and far more than what is rounded.
int fraction_q16(int part, int whole) { return int((double(part) * double(1 << 16) + 0.5lf) / double(whole)); }
#else
// By long division in 4-bit digits.
int fraction_q16(int part, int whole) {
    int quotient = part / whole;
    int rest = part - quotient * whole;
    for (int digit = 0; digit < 4; ++digit) {
        rest = rest * 16;
        int d = rest / whole;
        rest = rest - d * whole;
        quotient = quotient * 16 + d;
    }
    return quotient;
}
#endif

CONST_INT(kRootMost, 46340)  // its square is the largest in 31 bits

// Whole square root, rounded down, by Newton's method from above.
int square_root(int square) {
    int root = kRootMost;
    while (root > 1 && (root / 2) * (root / 2) > square) root = root / 2;
    for (int i = 0; square > 0 && i < 24; ++i) {
        int better = (root + square / root) / 2;
        if (better >= root) return root;
        root = better;
    }
    return square > 0 ? root : 0;
}

// How many bits are set, and the number of the lowest one; not of 0.
int bit_count(int bits) { return bitCount(bits); }
int lowest_bit(int bits) { return findLSB(bits); }

// Of a float's bits: its exponent, that of 1, and its fraction.
CONST_INT(kExponentShift, 23)
CONST_INT(kExponentMask, 255)
CONST_INT(kExponentOfOne, 127)
CONST_INT(kFractionMask, 0x7FFFFF)
CONST_INT(kFractionOne, 0x800000)

// a / b rounded to the nearest float, where none of the three is denormal: as C++ has it, and GLSL does not promise it. By long
// division of the fractions in 6-bit digits, to one bit more than a float has. No quotient lies half way between two floats.
float divide_exact(float a, float b) {
    int a_bits = floatBitsToInt(a);
    int b_bits = floatBitsToInt(b);
    int sign_bit = (a_bits ^ b_bits) & (1 << 31);
    int a_exponent = (a_bits >> kExponentShift) & kExponentMask;
    if (a_exponent == 0) return intBitsToFloat(sign_bit);
    int exponent = a_exponent - ((b_bits >> kExponentShift) & kExponentMask) + kExponentOfOne;
    int rest = (a_bits & kFractionMask) | kFractionOne;
    int whole = (b_bits & kFractionMask) | kFractionOne;
    if (rest < whole) {
        rest = rest * 2;
        exponent = exponent - 1;
    }
    int quotient = 1;
    rest = rest - whole;
    for (int digit = 0; digit < 4; ++digit) {
        rest = rest * 64;
        int d = rest / whole;
        rest = rest - d * whole;
        quotient = quotient * 64 + d;
    }
    return intBitsToFloat(sign_bit | ((exponent << kExponentShift) + ((quotient + 1) >> 1) - kFractionOne));
}

/* Procedural densities: fractal gradient noise (Perlin 2002); a cumulus of balls on a flat base, displaced by billows
 * of cellular noise (Worley 1996); a nebula of balls along an arch, displaced by gradient noise.
 *
 * The unit of length is the box's longest side, in a frame with y up, so that voxels are cubes and a cloud along z is
 * the rotated cloud along y. Rows along x are computed as a whole: quantities that depend only on y and z are computed
 * once per lattice column, not once per voxel. */
#include "base/context.h"
#include "grid/grid.h"

enum {
    SIZE_MAX_AXIS = 4096,
    OCTAVES_MAX = 12,
    SCRATCH_ROWS = 3,
    NEIGHBOURS = 27,
    TOWERS = 4,
    TOWER_LOBES = 9,
    LOBES = TOWERS * TOWER_LOBES
};

/* Maximum number of lattice cells across the box; octaves with less than two voxels per cell are dropped. */
static const float frequency_max = 4096.0f;
/* Height of a cloud's flat base, relative to the box. */
static const float base_height = 0.15f;

/* A ball of the cloud's body, in box units. */
typedef struct lobe {
    float x, y, z, radius;
} lobe;

typedef struct noise_job {
    ty_noise_def def;
    float cell;      /* voxel edge in box units: 1 / longest side in voxels */
    int32_t up_size; /* voxels along the up axis, and along the axis perpendicular to it and to x */
    int32_t side_size;
    float extent[3]; /* of the box, in box units, y up */
    float amplitude; /* cloud: displacement of the surface by billows, box units */
    float inflate;   /* cloud: displacement of the surface by coverage, box units */
    float slope;     /* cloud: density per box unit of depth */
    lobe lobes[LOBES];
    uint16_t* values;
    float* scratch; /* per worker: SCRATCH_ROWS rows of size[0] */
} noise_job;

void ty_init_noise_def(void* def, size_t bytes) {
    const ty_noise_def own = {.kind = TY_NOISE_CLOUD,
                              .size = {96, 96, 96},
                              .seed = 1,
                              .up_axis = 1,
                              .frequency = 4,
                              .octaves = 5,
                              .gain = 0.5f,
                              .lacunarity = 2,
                              .coverage = 0.5f,
                              .sharpness = 4};
    ty_init_def(def, bytes, &own, sizeof own);
}

static ty_result check_range(ty_context* context, const char* field, float value, float low, bool open, float high) {
    if (value <= high && (open ? value > low : value >= low)) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT, "noise %s is %g, outside %c%g, %g]", field, (double)value,
                   open ? '(' : '[', (double)low, (double)high);
}

static ty_result check_def(ty_context* context, const ty_noise_def** given, ty_noise_def* own) {
    *own = ty_default_noise_def();
    ty_result result = ty_take_def(context, *given, "ty_default_noise_def", own, sizeof *own);
    const ty_noise_def* def = *given = own;
    if (result != TY_OK) return result;
    if (def->kind < TY_NOISE_CONSTANT || def->kind > TY_NOISE_NEBULA)
        return ty_fail(context, TY_ERROR_ARGUMENT, "noise kind is %d, not a ty_noise_kind", (int)def->kind);
    for (int a = 0; a < 3; ++a)
        if (def->size[a] < 1 || def->size[a] > SIZE_MAX_AXIS)
            return ty_fail(context, TY_ERROR_ARGUMENT, "noise size along %c is %d, outside 1..%d", "xyz"[a],
                           def -> size[a], SIZE_MAX_AXIS);
    if (def->up_axis != 1 && def->up_axis != 2)
        return ty_fail(context, TY_ERROR_ARGUMENT, "noise up_axis is %d, neither 1 (y) nor 2 (z)", def->up_axis);
    if (def->octaves < 1 || def->octaves > OCTAVES_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "noise octaves is %d, outside 1..%d", def->octaves, OCTAVES_MAX);
    if (result == TY_OK) result = check_range(context, "frequency", def->frequency, 0, true, frequency_max);
    if (result == TY_OK) result = check_range(context, "gain", def->gain, 0, true, 1);
    if (result == TY_OK) result = check_range(context, "lacunarity", def->lacunarity, 1, false, frequency_max);
    if (result == TY_OK) result = check_range(context, "coverage", def->coverage, 0, false, 1);
    if (result == TY_OK) result = check_range(context, "sharpness", def->sharpness, 0, true, 1e6f);
    return result;
}

/* Hash of a lattice point (the finaliser of MurmurHash3 over three odd multiples). */
static uint32_t hash(uint32_t seed, int32_t x, int32_t y, int32_t z) {
    uint32_t h = seed * 0x9e3779b1u ^ (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u ^ (uint32_t)z * 0xcb1ab31fu;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

/* The nth uniform number in [0, 1) of a word. */
static float uniform(uint32_t word, uint32_t n) {
    return (float)(hash(word, (int32_t)n, 0, 0) >> 8) * 0x1p-24f;
}

static float smooth(float t) {
    t = ty_clampf(t, 0, 1);
    return t * t * (3 - 2 * t);
}

/* Perlin's interpolant t^3 (6 t^2 - 15 t + 10). */
static float fade(float t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

/* Gradient noise near a lattice column of a row is a + b fx, with fx the distance along x from the column. */
typedef struct column {
    float a, b;
} column;

static column gradient_column(uint32_t seed, int32_t cx, float y, float z) {
    const float floor_y = floorf(y), floor_z = floorf(z);
    const float fy = y - floor_y, fz = z - floor_z;
    const float blend[2][2] = {{1 - fade(fy), fade(fy)}, {1 - fade(fz), fade(fz)}};
    column sum = {0, 0};
    for (int32_t j = 0; j < 2; ++j)
        for (int32_t k = 0; k < 2; ++k) {
            const uint32_t h = hash(seed, cx, (int32_t)floor_y + j, (int32_t)floor_z + k);
            const float gx = (float)(h & 1023u) - 511.5f;
            const float gy = (float)(h >> 10 & 1023u) - 511.5f;
            const float gz = (float)(h >> 20 & 1023u) - 511.5f;
            const float weight = blend[0][j] * blend[1][k] / sqrtf(gx * gx + gy * gy + gz * gz);
            sum.a += weight * (gy * (fy - (float)j) + gz * (fz - (float)k));
            sum.b += weight * gx;
        }
    return sum;
}

/* Adds amplitude times gradient noise to a row; x is first + step i. */
static void add_gradient_row(float* row, int32_t count, float first, float step, float y, float z, float amplitude,
                             uint32_t seed) {
    int32_t cell = INT32_MIN;
    column left = {0, 0}, right = {0, 0};
    for (int32_t i = 0; i < count; ++i) {
        const float x = first + step * (float)i;
        const int32_t here = (int32_t)floorf(x);
        if (here != cell) {
            left = cell != INT32_MIN && here == cell + 1 ? right : gradient_column(seed, here, y, z);
            right = gradient_column(seed, here + 1, y, z);
            cell = here;
        }
        const float f = x - (float)here;
        row[i] += amplitude * ty_lerpf(left.a + left.b * f, right.a + right.b * (f - 1), fade(f));
    }
}

/* Adds amplitude times billows to the voxels of a row with |depth| <= reach: 1 - 2 d^2, d the distance to the nearest
 * of one random point per lattice cell, i.e. round bumps that meet in creases. */
static void add_billow_row(float* row, const float* depth, float reach, int32_t count, float first, float step, float y,
                           float z, float amplitude, uint32_t seed) {
    const int32_t cy = (int32_t)floorf(y), cz = (int32_t)floorf(z);
    int32_t cell = INT32_MIN;
    float px[NEIGHBOURS] = {0}, distance2_yz[NEIGHBOURS] = {0}; /* x coordinate; squared distance in y and z */
    for (int32_t i = 0; i < count; ++i) {
        if (depth[i] > reach || depth[i] < -reach) continue;
        const float x = first + step * (float)i;
        const int32_t here = (int32_t)floorf(x);
        if (here != cell) {
            for (int32_t n = 0; n < NEIGHBOURS; ++n) {
                const int32_t nx = here + n % 3 - 1, ny = cy + n / 3 % 3 - 1, nz = cz + n / 9 - 1;
                const uint32_t h = hash(seed, nx, ny, nz);
                const float dy = (float)ny + (float)(h >> 10 & 1023u) * 0x1p-10f - y;
                const float dz = (float)nz + (float)(h >> 20 & 1023u) * 0x1p-10f - z;
                px[n] = (float)nx + (float)(h & 1023u) * 0x1p-10f;
                distance2_yz[n] = dy * dy + dz * dz;
            }
            cell = here;
        }
        float min_distance2 = 1;
        for (int32_t n = 0; n < NEIGHBOURS; ++n) {
            const float dx = px[n] - x;
            min_distance2 = ty_minf(min_distance2, dx * dx + distance2_yz[n]);
        }
        row[i] += amplitude * (1 - 2 * min_distance2);
    }
}

/* Lattice cells per box unit of an octave. Returns whether the grid resolves it; the first octave always counts. */
static bool octave_frequency(const noise_job* job, int32_t octave, float* frequency) {
    *frequency = job->def.frequency;
    for (int32_t o = 0; o < octave; ++o) *frequency *= job->def.lacunarity;
    return octave == 0 || *frequency * job->cell <= 0.5f;
}

/* Gradient noise of all octaves, scaled to a standard deviation of about 1. */
static void fractal_row(const noise_job* job, float y, float z, float* row) {
    const float octave_deviation = 0.2f; /* standard deviation of one octave */
    float amplitude = 1, power = 0, frequency = 0;
    memset(row, 0, (size_t)job->def.size[0] * sizeof *row);
    for (int32_t o = 0; o < job->def.octaves && octave_frequency(job, o, &frequency); ++o) {
        const float step = frequency * job->cell;
        add_gradient_row(row, job->def.size[0], 0.5f * step, step, y * frequency, z * frequency, amplitude,
                         hash(job->def.seed, o, 103, 0));
        power += amplitude * amplitude;
        amplitude *= job->def.gain;
    }
    const float normal = 1 / (octave_deviation * sqrtf(power));
    for (int32_t i = 0; i < job->def.size[0]; ++i) row[i] *= normal;
}

/* Approximate normal CDF: a rational (1 + tanh(0.8 x)) / 2. */
static float normal_cdf(float x) {
    const float t = ty_clampf(0.8f * x, -3, 3);
    return 0.5f + 0.5f * t * (27 + t * t) / (27 + 9 * t * t);
}

static void fbm_row(const noise_job* job, float y, float z, float* row) {
    const float s = job->def.sharpness;
    fractal_row(job, y, z, row);
    /* Coverage 0 leaves nothing, 1 fills all, and in between about that fraction of the box is above one half. */
    for (int32_t i = 0; i < job->def.size[0]; ++i)
        row[i] = ty_clampf(s * (normal_cdf(row[i]) - 1) + job->def.coverage * (s + 1), 0, 1);
}

/* Body of a cumulus: towers of balls on a common base, the first central and the highest, with clearance for billows
 * between them and the box. */
static void create_cumulus(noise_job* job) {
    const float* e = job->extent;
    const float reach = 0.5f * ty_minf(e[0], e[2]); /* half the box's narrower side */
    const float margin = 0.03f + job->amplitude;
    const float azimuth = uniform(job->def.seed, 0);
    for (int32_t t = 0; t < TOWERS; ++t) {
        const uint32_t word = hash(job->def.seed, t, 101, 0);
        float sine, cosine;
        ty_sincos_2pi(fmodf(azimuth + ((float)t + 0.8f * uniform(word, 0)) / (TOWERS - 1), 1), &sine, &cosine);
        const float center_distance = t == 0 ? 0.0f : 0.36f + 0.14f * uniform(word, 1);
        const float height = t == 0 ? 0.6f : 0.2f + 0.26f * uniform(word, 2);
        const float width = t == 0 ? 0.44f : 0.28f + 0.12f * uniform(word, 3);
        for (int32_t i = 0; i < TOWER_LOBES; ++i) {
            const uint32_t ball = hash(word, i, 102, 0);
            const float rise = ((float)i + 0.5f) / TOWER_LOBES;
            const float off = width * (1 - 0.75f * rise) * sqrtf(uniform(ball, 1));
            float side, front;
            ty_sincos_2pi(uniform(ball, 0), &side, &front);
            lobe* l = &job->lobes[t * TOWER_LOBES + i];
            l->radius = reach * width * (0.7f + 0.4f * uniform(ball, 2)) * (1 - 0.45f * rise);
            const float gap = margin + l->radius;
            l->x = ty_clampf(e[0] * (0.5f + 0.5f * center_distance * cosine) + reach * off * front, gap,
                             ty_maxf(gap, e[0] - gap));
            l->z = ty_clampf(e[2] * (0.5f + 0.5f * center_distance * sine) + reach * off * side, gap,
                             ty_maxf(gap, e[2] - gap));
            l->y = ty_minf(e[1] * (base_height + height * rise), e[1] - gap);
        }
    }
}

/* Body of a nebula: an arch of balls across the box, and a single ball under it, in the arch's shadow under light from
 * above. */
static void create_nebula(noise_job* job) {
    const float* e = job->extent;
    const float side = ty_minf(ty_minf(e[0], e[1]), e[2]);
    for (int32_t i = 0; i < LOBES; ++i) {
        const uint32_t ball = hash(job->def.seed, i, 105, 0);
        const float arch_position = ((float)i + 0.5f) / (LOBES - 1), width = 0.29f + 0.05f * uniform(ball, 0);
        float sine, cosine;
        ty_sincos_2pi(fmodf(0.93f + 0.64f * arch_position, 1), &sine, &cosine);
        job->lobes[i] = (lobe){.x = 0.5f * e[0] + side * width * cosine,
                               .y = 0.48f * e[1] + side * width * sine,
                               .z = 0.5f * e[2] + side * 0.16f * (uniform(ball, 1) - 0.5f),
                               .radius = side * (0.06f + 0.07f * uniform(ball, 2))};
    }
    job->lobes[LOBES - 1] = (lobe){.x = 0.5f * e[0], .y = 0.24f * e[1], .z = 0.5f * e[2], .radius = 0.1f * side};
}

/* Depth of each voxel of a row below the body's surface, box units: the smooth maximum over balls. */
static void depth_row(const noise_job* job, float y, float z, float* depth) {
    const float blend = 0.03f;
    const float far = -1;
    for (int32_t i = 0; i < job->def.size[0]; ++i) depth[i] = far;
    for (int32_t n = 0; n < LOBES; ++n) {
        const lobe l = job->lobes[n];
        const float distance2_yz = (y - l.y) * (y - l.y) + (z - l.z) * (z - l.z);
        for (int32_t i = 0; i < job->def.size[0]; ++i) {
            const float dx = ((float)i + 0.5f) * job->cell - l.x;
            const float ball_depth = l.radius - sqrtf(dx * dx + distance2_yz);
            const float h = ty_maxf(blend - fabsf(ball_depth - depth[i]), 0);
            depth[i] = ty_maxf(ball_depth, depth[i]) + 0.25f * h * h / blend;
        }
    }
}

static void cloud_row(const noise_job* job, float y, float z, float* row, float* depth, float* wisps) {
    const int32_t count = job->def.size[0];
    const float reach = 2.2f * job->amplitude + fabsf(job->inflate) + 1 / job->slope;
    depth_row(job, y, z, depth);
    memset(row, 0, (size_t)count * sizeof *row);
    float amplitude = job->amplitude, frequency = 0;
    for (int32_t o = 0; o < job->def.octaves && octave_frequency(job, o, &frequency); ++o) {
        const float step = frequency * job->cell;
        add_billow_row(row, depth, reach, count, 0.5f * step, step, y * frequency, z * frequency, amplitude,
                       hash(job->def.seed, o, 104, 0));
        amplitude *= job->def.gain;
    }
    fractal_row(job, y, z, wisps);
    const float above = y - base_height * job->extent[1];
    for (int32_t i = 0; i < count; ++i) {
        const float wisp = 0.15f * job->amplitude * wisps[i];
        const float round = depth[i] + row[i] + wisp;
        const float flat = above + 2 * wisp;
        const float inside = ty_minf(round, flat) + job->inflate;
        row[i] = ty_clampf(0.5f + job->slope * inside, 0, 1);
    }
}

/* Density that is high inside and decreases towards a surface displaced by noise. */
static void nebula_row(const noise_job* job, float y, float z, float* row, float* depth) {
    depth_row(job, y, z, depth);
    fractal_row(job, y, z, row);
    for (int32_t i = 0; i < job->def.size[0]; ++i) {
        const float inside = depth[i] + 0.6f * job->amplitude * row[i] + job->inflate;
        const float solid = ty_clampf(0.25f * job->slope * inside, 0, 1);
        row[i] = solid * solid;
    }
}

/* Fades to 0 over the outer twentieth of the box; the outermost voxels are 0. */
static void fade_faces(const noise_job* job, int32_t up, int32_t side, float* row) {
    const float rate = job->cell / 0.05f;
    const int32_t fixed = up < job->up_size - 1 - up ? up : job->up_size - 1 - up;
    const int32_t other = side < job->side_size - 1 - side ? side : job->side_size - 1 - side;
    const float edge = smooth(rate * (float)fixed) * smooth(rate * (float)other);
    for (int32_t i = 0; i < job->def.size[0]; ++i) {
        const int32_t distance_x = i < job->def.size[0] - 1 - i ? i : job->def.size[0] - 1 - i;
        row[i] *= edge * smooth(rate * (float)distance_x);
    }
}

static void noise_slice(void* user, int64_t index, int32_t worker) {
    const noise_job* job = user;
    const int32_t* size = job->def.size;
    float* row = job->scratch + (size_t)worker * SCRATCH_ROWS * (size_t)size[0];
    for (int32_t j = 0; j < size[1]; ++j) {
        /* (x, y, z) with z up is (x, z, -y) with y up. */
        const int32_t up = job->def.up_axis == 1 ? j : (int32_t)index;
        const int32_t side = job->def.up_axis == 1 ? (int32_t)index : size[1] - 1 - j;
        const float y = ((float)up + 0.5f) * job->cell, z = ((float)side + 0.5f) * job->cell;
        float *depth = row + size[0], *wisps = depth + size[0];
        switch (job->def.kind) {
        case TY_NOISE_CLOUD: cloud_row(job, y, z, row, depth, wisps); break;
        case TY_NOISE_NEBULA: nebula_row(job, y, z, row, depth); break;
        default: fbm_row(job, y, z, row); break;
        }
        if (job->def.kind != TY_NOISE_FBM) fade_faces(job, up, side, row);
        uint16_t* values = job->values + (size_t)size[0] * ((size_t)j + (size_t)size[1] * (size_t)index);
        for (int32_t i = 0; i < size[0]; ++i) values[i] = ty_float_to_half(row[i]);
    }
}

static void prepare_job(noise_job* job) {
    const ty_noise_def* def = &job->def;
    int32_t longest = def->size[0];
    for (int a = 1; a < 3; ++a) longest = def->size[a] > longest ? def->size[a] : longest;
    job->cell = 1 / (float)longest;
    job->up_size = def->up_axis == 1 ? def->size[1] : def->size[2];
    job->side_size = def->up_axis == 1 ? def->size[2] : def->size[1];
    job->extent[0] = (float)def->size[0] * job->cell;
    job->extent[1] = (float)job->up_size * job->cell;
    job->extent[2] = (float)job->side_size * job->cell;
    job->amplitude = ty_minf(0.26f / def->frequency, 0.08f);
    job->slope = 2.5f * def->sharpness * def->frequency;
    /* Coverage 0 empties the thickest ball, 1 fills the box's corners; the center of its range has little effect. */
    const float cover = 2 * def->coverage - 1;
    const float full_range = (cover < 0 ? 0.35f : 1.0f) + 2 * job->amplitude + 1 / job->slope;
    job->inflate = cover * (0.1f + 0.9f * cover * cover) * full_range;
    if (def->kind == TY_NOISE_NEBULA)
        create_nebula(job);
    else
        create_cumulus(job);
}

ty_result ty_grid_create_noise(ty_context* context, const ty_noise_def* def, ty_grid** out) {
    if (context == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_grid_create_noise: a pointer is NULL");
    ty_noise_def own;
    const ty_result result = check_def(context, &def, &own);
    if (result != TY_OK) return result;
    ty_grid_def grid = ty_default_grid_def();
    memcpy(grid.size, def->size, sizeof grid.size);
    grid.type = TY_GRID_F16;
    const size_t voxels = (size_t)def->size[0] * (size_t)def->size[1] * (size_t)def->size[2];
    noise_job job = {.def = *def};
    job.values = ty_alloc_array(context, voxels, sizeof *job.values, false);
    if (job.values == NULL) return TY_ERROR_MEMORY;
    if (def->kind == TY_NOISE_CONSTANT) {
        const uint16_t one = ty_float_to_half(1);
        for (size_t i = 0; i < voxels; ++i) job.values[i] = one;
        return ty_grid_adopt(context, &grid, job.values, out);
    }
    const size_t scratch = (size_t)ty_context_threads(context) * SCRATCH_ROWS * (size_t)def->size[0];
    job.scratch = ty_alloc_array(context, scratch, sizeof *job.scratch, false);
    if (job.scratch == NULL) {
        ty_free_array(context, job.values, voxels, sizeof *job.values);
        return TY_ERROR_MEMORY;
    }
    prepare_job(&job);
    ty_parallel_for(context, def->size[2], noise_slice, &job);
    ty_free_array(context, job.scratch, scratch, sizeof *job.scratch);
    return ty_grid_adopt(context, &grid, job.values, out);
}

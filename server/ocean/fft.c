#include "ocean/fft.h"

#include <math.h>
#include <pthread.h>

#include "base/simd.h"
#include "base/vec.h"

#define N PEL_FFT_N

typedef pel_lanes lanes;

static float twiddle_re[N], twiddle_im[N];
static pthread_once_t twiddles_once = PTHREAD_ONCE_INIT;

static void fill_twiddles(void)
{
    for (int i = 0; i < N; i++) {
        twiddle_re[i] = (float)cos(2.0 * PEL_PI * i / N);
        twiddle_im[i] = (float)sin(2.0 * PEL_PI * i / N);
    }
}

/* One pass of Stockham's radix-4 transform: n remaining points, `done` = N / n
 * already apart. */
PEL_INLINE void pass4(int n, int done, const struct pel_fft_strip *a,
                      struct pel_fft_strip *b)
{
    int quarter = n / 4;
    for (int p = 0; p < quarter; p++) {
        int t = p * done;
        float w1r = twiddle_re[t], w1i = twiddle_im[t];
        float w2r = twiddle_re[2 * t], w2i = twiddle_im[2 * t];
        float w3r = twiddle_re[3 * t], w3i = twiddle_im[3 * t];
        for (int q = 0; q < done; q++) {
            const lanes *ar = &a->re[q + done * p];
            const lanes *ai = &a->im[q + done * p];
            int s = done * quarter;
            lanes x0r = ar[0] + ar[2 * s], x0i = ai[0] + ai[2 * s];
            lanes x1r = ar[0] - ar[2 * s], x1i = ai[0] - ai[2 * s];
            lanes x2r = ar[s] + ar[3 * s], x2i = ai[s] + ai[3 * s];
            lanes x3r = ar[s] - ar[3 * s], x3i = ai[s] - ai[3 * s];
            lanes *br = &b->re[q + done * 4 * p];
            lanes *bi = &b->im[q + done * 4 * p];
            lanes y1r = x1r - x3i, y1i = x1i + x3r; /* x1 + i x3 */
            lanes y2r = x0r - x2r, y2i = x0i - x2i;
            lanes y3r = x1r + x3i, y3i = x1i - x3r;
            br[0] = x0r + x2r;
            bi[0] = x0i + x2i;
            br[done] = y1r * w1r - y1i * w1i;
            bi[done] = y1r * w1i + y1i * w1r;
            br[2 * done] = y2r * w2r - y2i * w2i;
            bi[2 * done] = y2r * w2i + y2i * w2r;
            br[3 * done] = y3r * w3r - y3i * w3i;
            bi[3 * done] = y3r * w3i + y3i * w3r;
        }
    }
}

PEL_CLONES static void transform(struct pel_fft_strip *a)
{
    struct pel_fft_strip b;
    pass4(256, 1, a, &b);
    pass4(64, 4, &b, a);
    pass4(16, 16, a, &b);
    pass4(4, 64, &b, a);
}

void pel_fft_strip(struct pel_fft_strip *strip)
{
    pthread_once(&twiddles_once, fill_twiddles);
    transform(strip);
}

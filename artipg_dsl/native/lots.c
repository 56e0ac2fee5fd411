/* Random words and addresses, as ``random`` has them: whole numbers, so there is one answer. */

#include "bodies.h"

enum { ROUNDS = 10 };

/* The words (4, n) of Philox4x32-10 for n addresses. Of lanes and attempts there is one for each address, or one for all where
   ``lanes`` or ``attempts`` is 1. */
OUT void philox(int64_t n, int64_t key, const uint64_t *address, int64_t lanes, const uint64_t *lane, int64_t attempts,
                const uint64_t *attempt, uint32_t *out) {
    for (int64_t i = 0; i < n; i++) {
        uint32_t c0 = (uint32_t)address[i], c1 = (uint32_t)(address[i] >> 32);
        uint32_t c2 = (uint32_t)lane[lanes == 1 ? 0 : i], c3 = (uint32_t)attempt[attempts == 1 ? 0 : i];
        uint32_t k0 = (uint32_t)key, k1 = (uint32_t)((uint64_t)key >> 32);
        for (int round = 0; round < ROUNDS; round++, k0 += 0x9E3779B9u, k1 += 0xBB67AE85u) {
            const uint64_t first = (uint64_t)c0 * 0xD2511F53u, second = (uint64_t)c2 * 0xCD9E8D57u;
            c0 = (uint32_t)(second >> 32) ^ c1 ^ k0, c1 = (uint32_t)second;
            c2 = (uint32_t)(first >> 32) ^ c3 ^ k1, c3 = (uint32_t)first;
        }
        out[i] = c0, out[n + i] = c1, out[2 * n + i] = c2, out[3 * n + i] = c3;
    }
}

static uint64_t scramble(uint64_t word) {
    word = (word ^ word >> 30) * 0xBF58476D1CE4E5B9u;
    word = (word ^ word >> 27) * 0x94D049BB133111EBu;
    return word ^ word >> 31;
}

/* The addresses of n children, of the ``rank`` each; of parents there is one for each, or one for all. */
OUT void mix(int64_t n, int64_t parents, const uint64_t *parent, const uint64_t *rank, uint64_t *out) {
    for (int64_t i = 0; i < n; i++) {
        const uint64_t at = scramble(parent[parents == 1 ? 0 : i] + 0x9E3779B97F4A7C15u);
        out[i] = scramble(at + (rank[i] + 1) * 0x9E3779B97F4A7C15u);
    }
}

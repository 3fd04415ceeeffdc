/* gelpad's wire format, versions 1 to 3, for firmware: see docs/wire.md.
 *
 * A single header for C99 or C++, without libraries, allocation or tables, for the smallest boards.
 *
 *     static uint8_t packet[GELPAD_PACKET_MAX(208)];
 *     float volts[208];
 *     uint32_t sequence = 0;
 *     ...
 *     size_t length = gelpad_encode_f32(packet, sizeof packet, sequence++, micros(), volts, 208);
 *     Serial.write(packet, length);
 *
 * A board that reads one drive after another sends the readings of each drive as soon as it has them:
 *
 *     for (drive = 0; drive < 16; drive++) {
 *         read_drive(drive, &volts[13 * drive]);
 *         length = gelpad_encode_part_f32(packet, sizeof packet, sequence, micros(), volts, 208, 13 * drive, 13);
 *         Serial.write(packet, length);
 *     }
 *     sequence++;
 *
 * A board with an order of its own (`gelpad study protocol` writes such tables) names its readings at start-up and every hundred
 * frames:
 *
 *     length = gelpad_encode_readings(packet, sizeof packet, gelpad_readings, 208);
 *
 * Send one zero byte at start-up, so that earlier bytes are not part of the first packet.
 * Licensed under MIT or Apache-2.0, at your choice.
 */
#ifndef GELPAD_WIRE_H
#define GELPAD_WIRE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GELPAD_VERSION 1      /* a packet that holds a frame */
#define GELPAD_PART_VERSION 2 /* a packet that holds some values of a frame */
#define GELPAD_READINGS_VERSION 3 /* a packet that names the readings of a frame */
#define GELPAD_KIND_F32 1 /* volts, or any other unit, the same for all values */
#define GELPAD_KIND_I32 2 /* counts of a converter */
#define GELPAD_MOST_VALUES 2048

/* Bytes before stuffing: head, place of the values, values, check sum. */
#define GELPAD_BODY(count) (16u + 4u * (size_t)(count) + 4u)
/* Largest size of a packet of count values: one more byte for every 254, one at the start, the closing zero. */
#define GELPAD_PACKET_MAX(count) (GELPAD_BODY(count) + GELPAD_BODY(count) / 254u + 2u)

/* A packet under construction. COBS replaces every zero by the distance to the next one. */
typedef struct {
    uint8_t *out;
    size_t length; /* bytes written */
    size_t code;   /* where the distance of this block goes */
    uint32_t sum;
} gelpad_packet;

static inline void gelpad_stuff(gelpad_packet *p, uint8_t byte) {
    if (byte != 0) {
        p->out[p->length++] = byte;
    }
    if (byte == 0 || p->length - p->code == 255) {
        p->out[p->code] = (uint8_t)(p->length - p->code);
        p->code = p->length++;
    }
}

/* CRC-32 as in zlib, Ethernet and PNG, bit by bit. */
static inline void gelpad_put(gelpad_packet *p, uint8_t byte) {
    int bit;
    p->sum ^= byte;
    for (bit = 0; bit < 8; bit++) {
        p->sum = (p->sum >> 1) ^ (0xedb88320u & (0u - (p->sum & 1u)));
    }
    gelpad_stuff(p, byte);
}

static inline void gelpad_put_u32(gelpad_packet *p, uint32_t word) {
    int byte;
    for (byte = 0; byte < 4; byte++) {
        gelpad_put(p, (uint8_t)(word >> (8 * byte)));
    }
}

static inline void gelpad_put_u16(gelpad_packet *p, uint16_t word) {
    gelpad_put(p, (uint8_t)word);
    gelpad_put(p, (uint8_t)(word >> 8));
}

static inline int gelpad_begin(gelpad_packet *p, uint8_t *out, size_t room, uint8_t version, uint8_t kind,
                               uint32_t sequence, uint32_t time_us, uint16_t count) {
    if (count > GELPAD_MOST_VALUES || room < GELPAD_PACKET_MAX(count)) {
        return 0;
    }
    p->out = out;
    p->length = 1;
    p->code = 0;
    p->sum = 0xffffffffu;
    gelpad_put(p, version);
    gelpad_put(p, kind);
    gelpad_put_u16(p, count);
    gelpad_put_u32(p, sequence);
    gelpad_put_u32(p, time_us);
    return 1;
}

static inline size_t gelpad_end(gelpad_packet *p) {
    uint32_t sum = ~p->sum;
    int byte;
    for (byte = 0; byte < 4; byte++) {
        gelpad_stuff(p, (uint8_t)(sum >> (8 * byte)));
    }
    p->out[p->code] = (uint8_t)(p->length - p->code);
    p->out[p->length++] = 0;
    return p->length;
}

/* Writes a packet of volts; returns its length including the closing zero, or 0 if there is no room. */
static inline size_t gelpad_encode_f32(uint8_t *out, size_t room, uint32_t sequence, uint32_t time_us,
                                       const float *values, uint16_t count) {
    gelpad_packet p;
    uint16_t index;
    if (!gelpad_begin(&p, out, room, GELPAD_VERSION, GELPAD_KIND_F32, sequence, time_us, count)) {
        return 0;
    }
    for (index = 0; index < count; index++) {
        uint32_t word;
        memcpy(&word, &values[index], sizeof word);
        gelpad_put_u32(&p, word);
    }
    return gelpad_end(&p);
}

/* The same for counts. */
static inline size_t gelpad_encode_i32(uint8_t *out, size_t room, uint32_t sequence, uint32_t time_us,
                                       const int32_t *values, uint16_t count) {
    gelpad_packet p;
    uint16_t index;
    if (!gelpad_begin(&p, out, room, GELPAD_VERSION, GELPAD_KIND_I32, sequence, time_us, count)) {
        return 0;
    }
    for (index = 0; index < count; index++) {
        gelpad_put_u32(&p, (uint32_t)values[index]);
    }
    return gelpad_end(&p);
}

/* The place of the values of a part, after the head. */
static inline int gelpad_begin_part(gelpad_packet *p, uint8_t *out, size_t room, uint8_t kind, uint32_t sequence,
                                    uint32_t time_us, uint16_t total, uint16_t first, uint16_t count) {
    if (total > GELPAD_MOST_VALUES || first > total || count > total - first ||
        !gelpad_begin(p, out, room, GELPAD_PART_VERSION, kind, sequence, time_us, count)) {
        return 0;
    }
    gelpad_put_u16(p, first);
    gelpad_put_u16(p, total);
    return 1;
}

/* A packet of count of a frame's total values, from values[first] on. The parts of a frame have one sequence number, are sent in
 * order and each once; time_us is when these values were read. */
static inline size_t gelpad_encode_part_f32(uint8_t *out, size_t room, uint32_t sequence, uint32_t time_us,
                                            const float *values, uint16_t total, uint16_t first, uint16_t count) {
    gelpad_packet p;
    uint16_t index;
    if (!gelpad_begin_part(&p, out, room, GELPAD_KIND_F32, sequence, time_us, total, first, count)) {
        return 0;
    }
    for (index = 0; index < count; index++) {
        uint32_t word;
        memcpy(&word, &values[first + index], sizeof word);
        gelpad_put_u32(&p, word);
    }
    return gelpad_end(&p);
}

/* The same for counts. */
static inline size_t gelpad_encode_part_i32(uint8_t *out, size_t room, uint32_t sequence, uint32_t time_us,
                                            const int32_t *values, uint16_t total, uint16_t first, uint16_t count) {
    gelpad_packet p;
    uint16_t index;
    if (!gelpad_begin_part(&p, out, room, GELPAD_KIND_I32, sequence, time_us, total, first, count)) {
        return 0;
    }
    for (index = 0; index < count; index++) {
        gelpad_put_u32(&p, (uint32_t)values[first + index]);
    }
    return gelpad_end(&p);
}

/* A packet that names count readings in the order of the frame. Each has four electrodes, counted from 0: current flows into the
 * first and out of the second; the value is the potential of the fourth minus that of the third. */
static inline size_t gelpad_encode_readings(uint8_t *out, size_t room, const uint8_t readings[][4], uint16_t count) {
    gelpad_packet p;
    uint16_t index, electrode;
    if (!gelpad_begin(&p, out, room, GELPAD_READINGS_VERSION, 0, 0, 0, count)) {
        return 0;
    }
    for (index = 0; index < count; index++) {
        for (electrode = 0; electrode < 4; electrode++) {
            gelpad_put(&p, readings[index][electrode]);
        }
    }
    return gelpad_end(&p);
}

#ifdef __cplusplus
}
#endif

#endif

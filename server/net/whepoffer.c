#include "net/whepoffer.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>

#include <glib.h>

#include "net/command.h"

#define HASH "sha-256"
#define HASH_BYTES 32
/* RFC 8839, 5.4: at least so many characters. */
#define UFRAG_MIN 4
#define PASSWORD_MIN 22
#define MOST_TYPES 64 /* of one line that are looked at */
#define GROUPS 4      /* likewise of an offer */
#define DATA "webrtc-datachannel"
#define SCTP_PORT 5000 /* RFC 8841: what everybody takes */

/* --- words ---------------------------------------------------------------- */

/* The value after a prefix, or NULL. */
static const char *after(const char *line, const char *prefix)
{
    return g_str_has_prefix(line, prefix) ? line + strlen(prefix) : NULL;
}

/* RFC 8866's token, and short enough. */
static bool is_token(const char *text, size_t room)
{
    size_t length = strlen(text);
    for (size_t i = 0; i < length; i++) {
        if (!g_ascii_isalnum(text[i]) &&
            !strchr("-_.+!#$%&'*^`{|}~", text[i])) {
            return false;
        }
    }
    return length > 0 && length < room;
}

/* ice-char of RFC 8839. */
static bool is_ice(const char *text, size_t least, size_t room)
{
    size_t length = strlen(text);
    for (size_t i = 0; i < length; i++) {
        if (!g_ascii_isalnum(text[i]) && text[i] != '+' && text[i] != '/') {
            return false;
        }
    }
    return length >= least && length < room;
}

/* "sha-256 " and its bytes; other hashes are not asked for. */
static bool is_fingerprint(const char *text)
{
    const char *at = text + strlen(HASH);
    if (g_ascii_strncasecmp(text, HASH " ", strlen(HASH) + 1) != 0) {
        return false;
    }
    for (int i = 0; i < HASH_BYTES; i++) {
        char before = i == 0 ? ' ' : ':';
        if (at[0] != before || !g_ascii_isxdigit(at[1]) ||
            !g_ascii_isxdigit(at[2])) {
            return false;
        }
        at += 3;
    }
    return *at == '\0';
}

static bool is_numeric_address(const char *text)
{
    struct in6_addr room;
    return inet_pton(AF_INET, text, &room) == 1 ||
           inet_pton(AF_INET6, text, &room) == 1;
}

/* "FOUNDATION COMPONENT udp PRIORITY ADDRESS PORT typ TYPE …", of which the
 * rest is left out. */
static void keep_candidate(struct pel_whep_transport *out, const char *text)
{
    char foundation[36], proto[8], address[48], type[8];
    unsigned component, priority, port;
    bool read = sscanf(text, "%35s %3u %7s %10u %47s %5u typ %7s", foundation,
                       &component, proto, &priority, address, &port, type) == 7;
    bool known =
        read && (strcmp(type, "host") == 0 || strcmp(type, "srflx") == 0 ||
                 strcmp(type, "relay") == 0);
    if (!known || component != 1 || port == 0 || port > 65535 ||
        g_ascii_strcasecmp(proto, "udp") != 0 ||
        !is_ice(foundation, 1, sizeof foundation) ||
        !is_numeric_address(address) ||
        out->candidate_count == PEL_WHEP_CANDIDATES) {
        return;
    }
    snprintf(out->candidates[out->candidate_count++], sizeof out->candidates[0],
             "%s 1 UDP %u %s %u typ %s%s", foundation, priority, address, port,
             type, strcmp(type, "host") == 0 ? "" : " raddr 0.0.0.0 rport 9");
}

/* --- reading -------------------------------------------------------------- */

struct type {
    unsigned payload;
    bool h264, vp8;
    bool whole; /* packetization-mode=1 */
    bool rtx;   /* retransmissions of type `apt` */
    unsigned apt;
    char profile[8];
};

struct reader {
    struct pel_whep_offer *out;
    struct pel_whep_transport common; /* what holds for every line */
    struct pel_whep_transport own[PEL_WHEP_LINES];
    const char *groups[GROUPS]; /* the words behind BUNDLE */
    size_t group_count;
    bool in_media, takes; /* this line wants to receive */
    bool found;
    struct type types[MOST_TYPES]; /* of this line */
    size_t type_count;
};

static struct type *type_of(struct reader *r, unsigned payload)
{
    for (size_t i = 0; i < r->type_count; i++) {
        if (r->types[i].payload == payload) {
            return &r->types[i];
        }
    }
    if (payload > 127 || r->type_count == MOST_TYPES) {
        return NULL;
    }
    r->types[r->type_count] = (struct type){ .payload = payload };
    return &r->types[r->type_count++];
}

/* Our H.264 is constrained baseline: the more alike, the higher; VP8, which
 * takes an encoder of its own, where there is none; 0: no use. */
static int rank(const struct type *type)
{
    if (!type->h264 || !type->whole) {
        return type->vp8 ? 1 : 0;
    }
    unsigned id = (unsigned)g_ascii_strtoull(type->profile, NULL, 16);
    bool baseline = !type->profile[0] || id >> 16 == 0x42;
    return !baseline ? 2 : id >> 8 & 0x40 ? 4 : 3;
}

static void read_format(struct reader *r, const char *text)
{
    char *rest;
    struct type *type =
        type_of(r, (unsigned)MIN(g_ascii_strtoull(text, &rest, 10), 128));
    char **parts = g_strsplit(g_strchug(rest), ";", 16);
    for (int i = 0; type && parts[i]; i++) {
        const char *part = g_strstrip(parts[i]);
        const char *id = after(part, "profile-level-id=");
        const char *apt = after(part, "apt=");
        type->apt = apt ? (unsigned)MIN(g_ascii_strtoull(apt, NULL, 10), 128)
                        : type->apt;
        type->whole = type->whole || strcmp(part, "packetization-mode=1") == 0;
        if (id && strlen(id) == 6 &&
            strspn(id, "0123456789abcdefABCDEF") == 6) {
            g_strlcpy(type->profile, id, sizeof type->profile);
        }
    }
    g_strfreev(parts);
}

static void read_map(struct reader *r, const char *text)
{
    char *rest;
    struct type *type =
        type_of(r, (unsigned)MIN(g_ascii_strtoull(text, &rest, 10), 128));
    g_strchug(rest);
    if (type) {
        type->h264 = g_ascii_strcasecmp(rest, "H264/90000") == 0;
        type->vp8 = g_ascii_strcasecmp(rest, "VP8/90000") == 0;
        type->rtx = g_ascii_strcasecmp(rest, "rtx/90000") == 0;
    }
    struct pel_whep_line *line = &r->out->lines[r->out->line_count - 1];
    size_t length = strlen(line->format);
    bool first = strncmp(text, line->format, length) == 0 &&
                 !g_ascii_isdigit(text[length]);
    if (first && strlen(rest) < sizeof line->map &&
        strspn(rest, "-_.+/0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                     "abcdefghijklmnopqrstuvwxyz") == strlen(rest)) {
        g_strlcpy(line->map, rest, sizeof line->map);
    }
}

/* The line that has just ended gets the pictures, if it is the first that can
 * have them. */
static void end_line(struct reader *r)
{
    const struct type *best = NULL;
    for (size_t i = 0; i < r->type_count; i++) {
        if (rank(&r->types[i]) > (best ? rank(best) : 0)) {
            best = &r->types[i];
        }
    }
    size_t at = r->out->line_count - 1;
    bool video = r->in_media && !r->out->lines[at].off &&
                 strcmp(r->out->lines[at].kind, "video") == 0;
    if (!video || !best || !r->takes || r->found) {
        return;
    }
    r->found = true;
    r->out->video = at;
    r->out->payload = best->payload;
    r->out->vp8 = best->vp8;
    memcpy(r->out->profile, best->profile, sizeof best->profile);
    for (size_t i = 0; i < r->type_count; i++) {
        if (r->types[i].rtx && r->types[i].apt == best->payload) {
            r->out->rtx = r->types[i].payload;
        }
    }
}

/* --- groups ---------------------------------------------------------------
 */

/* The line of that mid, or -1. */
static int line_of(const struct pel_whep_offer *o, const char *mid)
{
    for (size_t i = 0; i < o->line_count; i++) {
        if (o->lines[i].mid[0] && strcmp(o->lines[i].mid, mid) == 0) {
            return (int)i;
        }
    }
    return -1;
}

/* Where the pictures' line is in this group, the transport is that of the
 * group's first (RFC 9143, 7.2). */
static void take_group(struct pel_whep_offer *o, const char *words)
{
    char **mids = g_strsplit(words, " ", -1);
    int first = -1;
    const char *mine = o->lines[o->video].mid;
    if (mine[0] && g_strv_contains((const char *const *)mids, mine)) {
        o->in_group = true;
        for (int i = 0; mids[i]; i++) {
            int at = line_of(o, mids[i]);
            if (at >= 0 && !o->lines[at].off) {
                o->lines[at].grouped = true;
                first = first < 0 ? at : first;
            }
        }
        o->tagged = first < 0 ? o->video : (size_t)first;
    }
    g_strfreev(mids);
}

/* Whether a line that gets nothing can stay. */
static bool is_rtp(const struct pel_whep_line *line)
{
    bool named = line->map[0] || g_ascii_strtoull(line->format, NULL, 10) < 96;
    return strcmp(line->proto, "UDP/TLS/RTP/SAVPF") == 0 && named;
}

static bool is_data(const struct pel_whep_line *line)
{
    return strcmp(line->kind, "application") == 0 &&
           g_str_has_suffix(line->proto, "/DTLS/SCTP") &&
           strcmp(line->format, DATA) == 0;
}

/* Data have no state in which nothing is sent: they stay only where the
 * transport is theirs. */
static bool stays(const struct pel_whep_offer *o, size_t at)
{
    const struct pel_whep_line *line = &o->lines[at];
    return at == o->video ||
           (line->grouped &&
            (is_rtp(line) || (at == o->tagged && is_data(line))));
}

static void take_transport(struct reader *r)
{
    struct pel_whep_offer *o = r->out;
    const struct pel_whep_transport *order[] = { &r->own[o->tagged], &r->common,
                                                 &r->own[o->video] };
    o->transport = r->own[o->tagged];
    for (size_t i = 1; i < G_N_ELEMENTS(order); i++) {
#define ELSE(field)                                                            \
    if (!o->transport.field[0]) {                                              \
        memcpy(o->transport.field, order[i]->field,                            \
               sizeof o->transport.field);                                     \
    }
        ELSE(ufrag)
        ELSE(password)
        ELSE(fingerprint)
        ELSE(setup)
#undef ELSE
    }
    const struct pel_whep_transport *mine = &r->own[o->video];
    if (o->transport.candidate_count == 0 &&
        strcmp(mine->ufrag, o->transport.ufrag) == 0) {
        memcpy(o->transport.candidates, mine->candidates,
               sizeof mine->candidates);
        o->transport.candidate_count = mine->candidate_count;
    }
}

static bool begin_line(struct reader *r, const char *text)
{
    if (r->out->line_count == PEL_WHEP_LINES) {
        return false;
    }
    char **words = g_strsplit(text, " ", 5);
    r->takes = true;
    struct pel_whep_line *line = &r->out->lines[r->out->line_count];
    bool good =
        g_strv_length(words) >= 4 && is_token(words[0], sizeof line->kind) &&
        is_token(words[3], sizeof line->format) &&
        strlen(words[2]) < sizeof line->proto && words[2][0] != '\0' &&
        words[2][strspn(words[2], "ABCDEFGHIJKLMNOPQRSTUVWXYZ/")] == '\0';
    if (good) {
        *line = (struct pel_whep_line){ .mid = "" };
        g_strlcpy(line->kind, words[0], sizeof line->kind);
        g_strlcpy(line->proto, words[2], sizeof line->proto);
        g_strlcpy(line->format, words[3], sizeof line->format);
        line->off = strcmp(words[1], "0") == 0;
        r->out->line_count++;
        r->in_media = true;
        r->type_count = 0;
    }
    g_strfreev(words);
    return good;
}

static void keep(char *to, size_t room, const char *value, bool good)
{
    if (good) {
        g_strlcpy(to, value, room);
    }
}

static void read_attribute(struct reader *r, const char *line)
{
    struct pel_whep_transport *to =
        r->in_media ? &r->own[r->out->line_count - 1] : &r->common;
    const char *value;
    if ((value = after(line, "ice-ufrag:"))) {
        keep(to->ufrag, sizeof to->ufrag, value,
             is_ice(value, UFRAG_MIN, sizeof to->ufrag));
    } else if ((value = after(line, "ice-pwd:"))) {
        keep(to->password, sizeof to->password, value,
             is_ice(value, PASSWORD_MIN, sizeof to->password));
    } else if ((value = after(line, "fingerprint:"))) {
        keep(to->fingerprint, sizeof to->fingerprint, value,
             is_fingerprint(value));
    } else if ((value = after(line, "setup:"))) {
        keep(to->setup, sizeof to->setup, value,
             strcmp(value, "actpass") == 0 || strcmp(value, "active") == 0 ||
                 strcmp(value, "passive") == 0);
    } else if (!r->in_media) {
        if ((value = after(line, "group:BUNDLE ")) && r->group_count < GROUPS) {
            r->groups[r->group_count++] = value;
        }
    } else if (strcmp(line, "bundle-only") == 0) {
        /* Port 0 until it is known that it can share a transport. */
        r->out->lines[r->out->line_count - 1].off = false;
    } else if ((value = after(line, "mid:"))) {
        struct pel_whep_line *media = &r->out->lines[r->out->line_count - 1];
        keep(media->mid, sizeof media->mid, value,
             is_token(value, sizeof media->mid));
    } else if ((value = after(line, "rtpmap:"))) {
        read_map(r, value);
    } else if ((value = after(line, "fmtp:"))) {
        read_format(r, value);
    } else if ((value = after(line, "candidate:"))) {
        keep_candidate(to, value);
    } else if (strcmp(line, "sendonly") == 0 || strcmp(line, "inactive") == 0) {
        r->takes = false;
    }
}

static enum pel_err missing(struct pel_fault *fault, const char *what,
                            const char *cure)
{
    return pel_fault_value(fault, PEL_ERR_INVALID, what, "", cure);
}

static enum pel_err check(const struct reader *r, struct pel_fault *fault)
{
    const struct pel_whep_offer *o = r->out;
    if (!r->found) {
        return missing(fault, "m=video",
                       "the offer must have a video line that receives "
                       "(recvonly) H264/90000 with packetization-mode=1, or "
                       "VP8/90000: add such a transceiver before "
                       "createOffer()");
    }
    if (!stays(o, o->tagged)) {
        return missing(fault, "a=group:BUNDLE",
                       "must begin with a line of RTP (UDP/TLS/RTP/SAVPF) or "
                       "of a data channel, whose transport it is: offer video "
                       "first");
    }
    const struct pel_whep_transport *t = &o->transport;
    if (!t->ufrag[0] || !t->password[0]) {
        return missing(fault, t->ufrag[0] ? "a=ice-pwd" : "a=ice-ufrag",
                       "must be of 4 (ice-ufrag), 22 (ice-pwd) to 256 "
                       "characters of A-Z a-z 0-9 + /");
    }
    if (!t->fingerprint[0]) {
        return missing(fault, "a=fingerprint",
                       "must be sha-256 and 32 bytes, as AB:CD:…: media are "
                       "sent by DTLS-SRTP only");
    }
    return PEL_OK;
}

static enum pel_err malformed(struct pel_fault *fault, int number,
                              const char *line)
{
    char path[16];
    snprintf(path, sizeof path, "line %d", number);
    return pel_fault_value(fault, PEL_ERR_MALFORMED, path, line,
                           "is no line of SDP that an offer may have here "
                           "(RFC 8866: v=0 first, at most 16 lines m=)");
}

static enum pel_err read_lines(struct reader *r, char **lines,
                               struct pel_fault *fault)
{
    if (strcmp(g_strchomp(lines[0]), "v=0") != 0) {
        return malformed(fault, 1, lines[0]);
    }
    for (int i = 1; lines[i]; i++) {
        const char *line = g_strchomp(lines[i]);
        bool last = *line == '\0' && !lines[i + 1];
        bool plain = g_ascii_islower(line[0]) && line[1] == '=' &&
                     g_utf8_validate(line, -1, NULL);
        if (last) {
            break;
        }
        if (!plain) {
            return malformed(fault, i + 1, line);
        }
        if (line[0] == 'm') {
            end_line(r);
            if (!begin_line(r, line + 2)) {
                return malformed(fault, i + 1, line);
            }
        } else if (line[0] == 'a') {
            read_attribute(r, line + 2);
        }
    }
    end_line(r);
    r->out->tagged = r->out->video;
    for (size_t i = 0; r->found && i < r->group_count && !r->out->in_group;
         i++) {
        take_group(r->out, r->groups[i]);
    }
    take_transport(r);
    return check(r, fault);
}

enum pel_err pel_whep_offer_read(const char *text, size_t size,
                                 struct pel_whep_offer *out,
                                 struct pel_fault *fault)
{
    *out = (struct pel_whep_offer){ .video = 0 };
    if (size == 0 || memchr(text, '\0', size)) {
        return malformed(fault, 1, "");
    }
    struct reader *r = g_new0(struct reader, 1);
    r->out = out;
    char *copy = g_strndup(text, size);
    char **lines = g_strsplit(copy, "\n", -1);
    enum pel_err err = read_lines(r, lines, fault);
    g_strfreev(lines);
    g_free(copy);
    g_free(r);
    return err;
}

/* --- writing -------------------------------------------------------------- */

static void append_format(GString *out, const struct pel_whep_offer *offer)
{
    if (offer->vp8) {
        return;
    }
    g_string_append_printf(
        out, "a=fmtp:%u level-asymmetry-allowed=1;packetization-mode=1%s%s\r\n",
        offer->payload, offer->profile[0] ? ";profile-level-id=" : "",
        offer->profile);
}

/* What lets a peer ask for lost packets again. */
static void append_rtx(GString *out, const struct pel_whep_offer *offer)
{
    if (offer->rtx) {
        g_string_append_printf(out,
                               "a=rtcp-fb:%u nack\r\na=rtpmap:%u rtx/90000\r\n"
                               "a=fmtp:%u apt=%u\r\n",
                               offer->payload, offer->rtx, offer->rtx,
                               offer->payload);
    }
}

static const char *mid_of(const struct pel_whep_offer *offer)
{
    const char *mid = offer->lines[offer->video].mid;
    return mid[0] ? mid : "video";
}

char *pel_whep_offer_write(const struct pel_whep_offer *offer, bool candidates)
{
    GString *out = g_string_new(NULL);
    const struct pel_whep_transport *t = &offer->transport;
    const char *mid = mid_of(offer);
    unsigned pt = offer->payload;
    char rtx[16] = "";
    if (offer->rtx) {
        snprintf(rtx, sizeof rtx, " %u", offer->rtx);
    }
    g_string_append_printf(
        out,
        "v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\n"
        "a=group:BUNDLE %s\r\n"
        "m=video 9 UDP/TLS/RTP/SAVPF %u%s\r\nc=IN IP4 0.0.0.0\r\n"
        "a=ice-ufrag:%s\r\na=ice-pwd:%s\r\na=ice-options:trickle\r\n"
        "a=fingerprint:%s\r\na=setup:%s\r\na=mid:%s\r\na=recvonly\r\n"
        "a=rtcp-mux\r\na=rtpmap:%u %s/90000\r\n"
        "a=rtcp-fb:%u nack pli\r\na=rtcp-fb:%u ccm fir\r\n",
        mid, pt, rtx, t->ufrag, t->password, t->fingerprint,
        t->setup[0] ? t->setup : "actpass", mid, pt,
        offer->vp8 ? "VP8" : "H264", pt, pt);
    append_format(out, offer);
    append_rtx(out, offer);
    for (size_t i = 0; candidates && i < t->candidate_count; i++) {
        g_string_append_printf(out, "a=candidate:%s\r\n", t->candidates[i]);
    }
    return g_string_free(out, FALSE);
}

static bool is_candidate(const char *line)
{
    return g_str_has_prefix(line, "a=candidate:");
}

/* Our end of ICE and DTLS; the candidates once, where the transport is told. */
static void append_transport(GString *out, char *const *lines, bool candidates)
{
    static const char *const prefixes[] = { "a=ice-ufrag:", "a=ice-pwd:",
                                            "a=ice-options:", "a=fingerprint:",
                                            "a=setup:" };
    for (int i = 0; lines[i]; i++) {
        bool of_it = candidates && is_candidate(lines[i]);
        for (size_t p = 0; p < G_N_ELEMENTS(prefixes); p++) {
            of_it = of_it || g_str_has_prefix(lines[i], prefixes[p]);
        }
        if (of_it) {
            g_string_append_printf(out, "%s\r\n", lines[i]);
        }
    }
    g_string_append(out, candidates ? "a=end-of-candidates\r\n" : "");
}

/* The line of the pictures, with the profile that was offered: GStreamer leaves
 * it out, and browsers would take that for another one. */
static void append_media(GString *out, const struct pel_whep_offer *offer,
                         char *const *lines, const uint32_t *epoch)
{
    bool tagged = offer->tagged == offer->video;
    char format[24];
    snprintf(format, sizeof format, "a=fmtp:%u ", offer->payload);
    for (int i = 0; lines[i]; i++) {
        if (g_str_has_prefix(lines[i], format)) {
            append_format(out, offer);
        } else if (lines[i][0] && (tagged || !is_candidate(lines[i]))) {
            g_string_append_printf(out, "%s\r\n", lines[i]);
        }
    }
    if (epoch) {
        g_string_append_printf(
            out, "a=ts-refclk:private\r\na=mediaclk:direct=%u\r\n", *epoch);
    }
    g_string_append(out, tagged ? "a=end-of-candidates\r\n" : "");
}

/* Any other line. */
static void append_line(GString *out, const struct pel_whep_offer *offer,
                        size_t at, char *const *lines)
{
    const struct pel_whep_line *line = &offer->lines[at];
    bool here = stays(offer, at), rtp = is_rtp(line);
    g_string_append_printf(out, "m=%s %d %s %s\r\nc=IN IP4 0.0.0.0\r\n",
                           line->kind, here ? 9 : 0, line->proto, line->format);
    g_string_append(out, here && !rtp ? "" : "a=inactive\r\n");
    if (line->mid[0]) {
        g_string_append_printf(out, "a=mid:%s\r\n", line->mid);
    }
    if (!here) {
        return;
    }
    if (!rtp) {
        g_string_append_printf(out, "a=sctp-port:%d\r\n", SCTP_PORT);
    } else if (line->map[0]) {
        g_string_append_printf(out, "a=rtcp-mux\r\na=rtpmap:%s %s\r\n",
                               line->format, line->map);
    } else {
        g_string_append(out, "a=rtcp-mux\r\n");
    }
    append_transport(out, lines, at == offer->tagged);
}

/* Writes the lines before the first line of media; the group names the lines
 * that stay, the offer's first one first. */
static void append_head(GString *out, const struct pel_whep_offer *offer,
                        const char *answer, const char *media)
{
    char *head = g_strndup(answer, (gsize)(media - answer));
    char **lines = g_strsplit(head, "\r\n", -1);
    for (int i = 0; lines[i]; i++) {
        if (lines[i][0] && !g_str_has_prefix(lines[i], "a=group:BUNDLE")) {
            g_string_append_printf(out, "%s\r\n", lines[i]);
        }
    }
    g_strfreev(lines);
    g_free(head);
    if (!offer->in_group) {
        return;
    }
    g_string_append_printf(out, "a=group:BUNDLE %s",
                           offer->lines[offer->tagged].mid);
    for (size_t i = 0; i < offer->line_count; i++) {
        if (i != offer->tagged && stays(offer, i)) {
            g_string_append_printf(out, " %s", offer->lines[i].mid);
        }
    }
    g_string_append(out, "\r\n");
}

char *pel_whep_answer_write(const struct pel_whep_offer *offer,
                            const char *answer, const uint32_t *epoch)
{
    const char *media = strstr(answer, "m=video");
    if (!media) {
        return NULL;
    }
    GString *out = g_string_new(NULL);
    append_head(out, offer, answer, media);
    char **lines = g_strsplit(media, "\r\n", -1);
    for (size_t i = 0; i < offer->line_count; i++) {
        if (i == offer->video) {
            append_media(out, offer, lines, epoch);
        } else {
            append_line(out, offer, i, lines);
        }
    }
    g_strfreev(lines);
    return g_string_free(out, FALSE);
}

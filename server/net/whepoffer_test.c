#include "net/whepoffer.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <glib.h>

#define F16 "AB:CD:01:23:45:67:89:aB:cD:EF:00:11:22:33:44:55"
#define PRINT "sha-256 " F16 ":" F16
#define UFRAG "Ab12"
#define PASSWORD "abcdefghijklmnopqrst+/"
#define HEAD "v=0\r\no=- 1 2 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\n"
#define VIDEO "m=video 9 UDP/TLS/RTP/SAVPF 102\r\n"
#define ICE "a=ice-ufrag:" UFRAG "\r\na=ice-pwd:" PASSWORD "\r\n"
#define DTLS "a=fingerprint:" PRINT "\r\na=setup:actpass\r\n"
#define MAP "a=rtpmap:102 H264/90000\r\n"
#define FORMAT "a=fmtp:102 packetization-mode=1\r\n"
#define WHOLE HEAD VIDEO ICE DTLS MAP FORMAT

static struct pel_whep_offer offer;
static struct pel_fault fault;

static enum pel_err take(const char *text)
{
    memset(&fault, 0, sizeof fault);
    return pel_whep_offer_read(text, strlen(text), &offer, &fault);
}

static void good(const char *text)
{
    if (take(text)) {
        fail_msg("%s\n%s", fault.message, text);
    }
}

static void bad(const char *text, enum pel_err code, const char *path)
{
    assert_int_equal(take(text), code);
    assert_string_equal(fault.path, path);
    assert_non_null(strstr(fault.message, path));
}

/* `text` with one part of it replaced; until the next call. */
static const char *with(const char *text, const char *part, const char *by)
{
    static GString *out;
    if (!out) {
        out = g_string_new(NULL);
    }
    g_string_assign(out, text);
    assert_int_equal(g_string_replace(out, part, by, 1), 1);
    return out->str;
}

/* Chromium's order: everything again in each line, the best type last. */
static void chromium(void **state)
{
    (void)state;
    good(HEAD
         "a=group:BUNDLE 0 1 2\r\na=msid-semantic: WMS\r\n"
         "m=audio 9 UDP/TLS/RTP/SAVPF 111 63\r\n" ICE DTLS "a=mid:0\r\n"
         "a=recvonly\r\na=rtpmap:111 opus/48000/2\r\n"
         "m=video 9 UDP/TLS/RTP/SAVPF 96 97 102 104 108 116\r\n"
         "a=candidate:1 1 udp 2113937151 3d4b2c1e-0b3a.local 51472 typ host\r\n"
         "a=candidate:842163049 1 udp 1677729535 203.0.113.7 51472 typ srflx "
         "raddr 10.0.0.7 rport 51472 generation 0\r\n" ICE DTLS
         "a=mid:1\r\na=recvonly\r\na=rtpmap:96 VP8/90000\r\n"
         "a=rtpmap:97 rtx/90000\r\na=fmtp:97 apt=96\r\n" MAP
         "a=fmtp:102 level-asymmetry-allowed=1;packetization-mode=1;"
         "profile-level-id=42001f\r\na=rtpmap:104 H264/90000\r\n"
         "a=fmtp:104 packetization-mode=0;profile-level-id=42e01f\r\n"
         "a=rtpmap:108 H264/90000\r\na=fmtp:108 packetization-mode=1;"
         "profile-level-id=42e01f\r\na=rtpmap:109 rtx/90000\r\n"
         "a=fmtp:109 apt=108\r\na=rtpmap:116 H264/90000\r\n"
         "a=fmtp:116 packetization-mode=1;profile-level-id=4d001f\r\n"
         "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n" ICE DTLS
         "a=mid:2\r\na=sctp-port:5000\r\n");
    assert_int_equal(offer.line_count, 3);
    assert_int_equal(offer.video, 1);
    assert_int_equal(offer.payload, 108); /* constrained baseline */
    assert_int_equal(offer.rtx, 109);
    assert_string_equal(offer.profile, "42e01f");
    assert_string_equal(offer.lines[1].mid, "1");
    assert_string_equal(offer.lines[2].kind, "application");
    assert_string_equal(offer.lines[2].format, "webrtc-datachannel");
    /* What hides its address is left out; nor is what it hides behind told. */
    assert_int_equal(offer.transport.candidate_count, 1);
    assert_string_equal(offer.transport.candidates[0],
                        "842163049 1 UDP 1677729535 203.0.113.7 51472 typ srflx"
                        " raddr 0.0.0.0 rport 9");
}

/* Firefox's: the fingerprint once for all, formats before their names. */
static void firefox(void **state)
{
    (void)state;
    good(
        "v=0\r\no=mozilla...THIS_IS_SDPARTA-99.0 1 0 IN IP4 0.0.0.0\r\ns=-\r\n"
        "t=0 0\r\na=fingerprint:" PRINT "\r\na=group:BUNDLE 0\r\n"
        "m=video 9 UDP/TLS/RTP/SAVPF 120 126 97\r\na=recvonly\r\n"
        "a=fmtp:126 profile-level-id=42e01f;level-asymmetry-allowed=1;"
        "packetization-mode=1\r\n"
        "a=fmtp:97 profile-level-id=42e01f;level-asymmetry-allowed=1\r\n" ICE
        "a=mid:0\r\na=rtpmap:120 VP8/90000\r\na=rtpmap:126 H264/90000\r\n"
        "a=rtpmap:97 H264/90000\r\na=setup:actpass\r\n"
        "a=candidate:0 1 UDP 2122252543 192.0.2.9 48811 typ host\r\n"
        "a=candidate:2 2 UDP 2122252542 192.0.2.9 48812 typ host\r\n"
        "a=candidate:1 1 TCP 2105524479 192.0.2.9 9 typ host tcptype active\r\n"
        "a=candidate:3 1 UDP 8331263 2001:db8::7 60001 typ relay raddr "
        "192.0.2.9 rport 48811\r\na=end-of-candidates\r\n");
    assert_int_equal(offer.payload, 126);
    assert_string_equal(offer.transport.fingerprint, PRINT);
    assert_int_equal(offer.transport.candidate_count, 2);
    assert_string_equal(offer.transport.candidates[1],
                        "3 1 UDP 8331263 2001:db8::7 60001 typ relay raddr "
                        "0.0.0.0 rport 9");
}

/* GStreamer's: one type, the attributes in another order, LF alone. */
static void gstreamer(void **state)
{
    (void)state;
    good("v=0\no=- 1 0 IN IP4 0.0.0.0\ns=-\nt=0 0\na=ice-options:trickle\n"
         "m=video 9 UDP/TLS/RTP/SAVPF 97\nc=IN IP4 0.0.0.0\na=setup:passive\n"
         "a=ice-ufrag:" UFRAG "\na=ice-pwd:" PASSWORD "\na=recvonly\n"
         "a=rtpmap:97 H264/90000\na=fmtp:97 packetization-mode=1\n"
         "a=mid:video0\na=fingerprint:" PRINT "\na=rtcp-mux-only");
    assert_string_equal(offer.lines[0].mid, "video0");
    assert_string_equal(offer.transport.setup, "passive");
    assert_string_equal(offer.profile, "");
}

static void what_is_missing_is_named(void **state)
{
    (void)state;
    good(WHOLE);
    bad(with(WHOLE, "a=ice-ufrag", "a=x"), PEL_ERR_INVALID, "a=ice-ufrag");
    bad(with(WHOLE, "a=ice-pwd", "a=x"), PEL_ERR_INVALID, "a=ice-pwd");
    bad(with(WHOLE, "sha-256", "sha-1"), PEL_ERR_INVALID, "a=fingerprint");
    bad(with(WHOLE, "m=video", "m=audio"), PEL_ERR_INVALID, "m=video");
    bad(with(WHOLE, "H264/90000", "H265/90000"), PEL_ERR_INVALID, "m=video");
    bad(with(WHOLE, "mode=1", "mode=0"), PEL_ERR_INVALID, "m=video");
    bad(with(WHOLE, "a=fmtp", "a=x"), PEL_ERR_INVALID, "m=video");
    bad(with(WHOLE, "a=setup:actpass", "a=sendonly"), PEL_ERR_INVALID,
        "m=video");
    bad(with(WHOLE, "a=setup:actpass", "a=inactive"), PEL_ERR_INVALID,
        "m=video");
    bad(HEAD, PEL_ERR_INVALID, "m=video");
}

static void what_is_no_sdp_is_named_by_its_line(void **state)
{
    (void)state;
    bad("", PEL_ERR_MALFORMED, "line 1");
    bad("v=1\r\n", PEL_ERR_MALFORMED, "line 1");
    bad(with(WHOLE, "s=-\r\n", "\r\n"), PEL_ERR_MALFORMED, "line 3");
    bad(with(WHOLE, "s=-", "S=-"), PEL_ERR_MALFORMED, "line 3");
    bad(with(WHOLE, "s=-", "s:-"), PEL_ERR_MALFORMED, "line 3");
    bad(with(WHOLE, "s=-", "s=\xff"), PEL_ERR_MALFORMED, "line 3");
    bad(with(WHOLE, VIDEO, "m=video 9 UDP/TLS/RTP/SAVPF\r\n"),
        PEL_ERR_MALFORMED, "line 5");
    bad(with(WHOLE, VIDEO, "m=video 9 udp 102\r\n"), PEL_ERR_MALFORMED,
        "line 5");
    bad(with(WHOLE, VIDEO, "m=vid@eo 9 UDP/TLS/RTP/SAVPF 102\r\n"),
        PEL_ERR_MALFORMED, "line 5");
    bad(with(WHOLE, VIDEO, "m=videovideovideovid 9 UDP/TLS/RTP/SAVPF 1\r\n"),
        PEL_ERR_MALFORMED, "line 5");
    assert_int_equal(pel_whep_offer_read("v=0\0", 4, &offer, &fault),
                     PEL_ERR_MALFORMED);
}

static char *repeated(const char *head, const char *part, size_t times,
                      const char *tail)
{
    GString *out = g_string_new(head);
    for (size_t i = 0; i < times; i++) {
        g_string_append(out, part);
    }
    g_string_append(out, tail);
    return g_string_free(out, FALSE);
}

#define EMPTY "m=audio 9 UDP/TLS/RTP/SAVPF 0\r\n"
#define MEDIA VIDEO ICE DTLS MAP FORMAT
#define CANDIDATE "a=candidate:1 1 UDP 1 192.0.2.9 7 typ host\r\n"

static void there_is_room_for_sixteen(void **state)
{
    (void)state;
    char *most = repeated(HEAD, EMPTY, PEL_WHEP_LINES - 1, MEDIA);
    char *more = repeated(HEAD, EMPTY, PEL_WHEP_LINES, MEDIA);
    char *many = repeated(HEAD MEDIA, CANDIDATE, PEL_WHEP_CANDIDATES + 1, "");
    good(most);
    assert_int_equal(offer.video, PEL_WHEP_LINES - 1);
    bad(more, PEL_ERR_MALFORMED, "line 21");
    good(many); /* the others are left out */
    assert_int_equal(offer.transport.candidate_count, PEL_WHEP_CANDIDATES);
    g_free(most);
    g_free(more);
    g_free(many);
}

static void sizes_of_words(void **state)
{
    (void)state;
    static const struct {
        const char *field, *value;
        size_t least, most;
    } cases[] = {
        { "a=ice-ufrag", UFRAG, 4, 256 },
        { "a=ice-pwd", PASSWORD, 22, 256 },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        size_t sizes[] = { cases[i].least - 1, cases[i].least, cases[i].most,
                           cases[i].most + 4 };
        for (size_t k = 0; k < G_N_ELEMENTS(sizes); k++) {
            char *value = g_strnfill(sizes[k], 'x');
            const char *text = with(WHOLE, cases[i].value, value);
            if (k == 1 || k == 2) {
                good(text);
            } else {
                bad(text, PEL_ERR_INVALID, cases[i].field);
            }
            g_free(value);
        }
        bad(with(WHOLE, cases[i].value, "abcdefghijklmnopqrstuvw!"),
            PEL_ERR_INVALID, cases[i].field);
    }
    bad(with(WHOLE, PRINT, PRINT ":00"), PEL_ERR_INVALID, "a=fingerprint");
    bad(with(WHOLE, PRINT, "sha-256 " F16), PEL_ERR_INVALID, "a=fingerprint");
    bad(with(WHOLE, "AB:CD", "AB;CD"), PEL_ERR_INVALID, "a=fingerprint");
    bad(with(WHOLE, "AB:CD", "AB:XD"), PEL_ERR_INVALID, "a=fingerprint");
    good(with(WHOLE, "sha-256", "SHA-256"));
}

/* Payload types are 0 to 127; others, and too many, are passed over. */
static void payload_types(void **state)
{
    (void)state;
    char *text = repeated(HEAD VIDEO ICE DTLS, "", 0, "");
    GString *many = g_string_new(text);
    good(with(with(WHOLE, "rtpmap:102", "rtpmap:127"), "fmtp:102", "fmtp:127"));
    assert_int_equal(offer.payload, 127);
    bad(with(with(WHOLE, "rtpmap:102", "rtpmap:128"), "fmtp:102", "fmtp:128"),
        PEL_ERR_INVALID, "m=video");
    bad(with(WHOLE, "fmtp:102", "fmtp:18446744073709551718"), PEL_ERR_INVALID,
        "m=video");
    for (int i = 0; i < 64; i++) {
        g_string_append_printf(many, "a=rtpmap:%d VP9/90000\r\n", i);
    }
    g_string_append(many, MAP FORMAT);
    bad(many->str, PEL_ERR_INVALID, "m=video");
    g_string_free(many, TRUE);
    g_free(text);
    /* What is no profile is passed over. */
    good(with(WHOLE, "mode=1", "mode=1;profile-level-id=42e01"));
    assert_string_equal(offer.profile, "");
}

static void candidates(void **state)
{
    (void)state;
    static const char *const none[] = {
        "1 1 UDP 1 192.0.2.9 0 typ host",
        "1 1 UDP 1 192.0.2.9 65536 typ host",
        "1 2 UDP 1 192.0.2.9 7 typ host",
        "1 1 TCP 1 192.0.2.9 7 typ host",
        "1 1 UDP 1 localhost 7 typ host",
        "1 1 UDP 1 192.0.2.9 7 typ prflx",
        "1 1 UDP 1 192.0.2.9 7",
        "a;b 1 UDP 1 192.0.2.9 7 typ host",
        "",
    };
    for (size_t i = 0; i < G_N_ELEMENTS(none); i++) {
        char *text = g_strdup_printf("%sa=candidate:%s\r\n", WHOLE, none[i]);
        good(text);
        assert_int_equal(offer.transport.candidate_count, 0);
        g_free(text);
    }
    /* The longest of all is kept whole. */
    good(WHOLE "a=candidate:12345678901234567890123456789012 1 UDP 4294967295 "
               "0000:0000:0000:0000:0000:ffff:255.255.255.255 65535 typ srflx "
               "raddr 10.0.0.1 rport 1\r\n");
    assert_int_equal(offer.transport.candidate_count, 1);
    assert_true(g_str_has_suffix(offer.transport.candidates[0],
                                 " typ srflx raddr 0.0.0.0 rport 9"));
}

static void only_what_was_checked_is_written(void **state)
{
    (void)state;
    good(HEAD "a=x:secret\r\n" EMPTY MEDIA
              "a=mid:v\r\na=y:secret\r\na=rtpmap:103 rtx/90000\r\n"
              "a=fmtp:103 apt=102\r\n" CANDIDATE);
    assert_int_equal(offer.rtx, 103);
    char *text = pel_whep_offer_write(&offer, true);
    assert_null(strstr(text, "secret"));
    assert_non_null(strstr(text, CANDIDATE));
    good(text);
    assert_int_equal(offer.line_count, 1);
    assert_int_equal(offer.rtx, 103);
    assert_string_equal(offer.transport.password, PASSWORD);
    g_free(text);
    text = pel_whep_offer_write(&offer, false);
    assert_null(strstr(text, "candidate"));
    g_free(text);
}

static struct pel_allow networks(const char *text)
{
    struct pel_allow out;
    assert_int_equal(pel_allow_parse(text, &out, &fault), PEL_OK);
    return out;
}

/* An offer may name sixteen candidates. */
static void few_are_sent_checks(void **state)
{
    (void)state;
    static const struct {
        const char *asker, *peers, *given[5], *kept[4];
    } cases[] = {
        /* Strangers are told nothing; who asked is, by address alone. */
        { "192.0.2.9",
          NULL,
          { "198.51.100.1", "10.0.0.7", "2001:db8::7" },
          { "192.0.2.9" } },
        { "192.0.2.9",
          NULL,
          { "198.51.100.1", "192.0.2.9", "::ffff:192.0.2.9", "192.0.2.9" },
          { "192.0.2.9", "::ffff:192.0.2.9", "192.0.2.9" } },
        { "2001:db8::7", NULL, { "2001:DB8:0::7" }, { "2001:DB8:0::7" } },
        { "192.0.2.9",
          "10.0.0.0/8,198.51.100.1",
          { "10.1.2.3", "11.1.2.3", "198.51.100.1", "198.51.100.2" },
          { "10.1.2.3", "198.51.100.1", "192.0.2.9" } },
        { "192.0.2.9",
          "10.0.0.0/8",
          { "10.0.0.1", "10.0.0.2", "10.0.0.3", "10.0.0.4" },
          { "10.0.0.1", "10.0.0.2", "192.0.2.9" } },
        /* This machine's. */
        { NULL,
          NULL,
          { "127.0.0.5", "::1", "198.51.100.1" },
          { "127.0.0.5", "::1" } },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct pel_allow peers = { 0 };
        GString *text = g_string_new(HEAD MEDIA "a=mid:v\r\n");
        if (cases[i].peers) {
            peers = networks(cases[i].peers);
        }
        for (int k = 0; k < 5 && cases[i].given[k]; k++) {
            g_string_append_printf(text,
                                   "a=candidate:%d 1 UDP 1 %s 7 typ host\r\n",
                                   k, cases[i].given[k]);
        }
        good(text->str);
        pel_whep_offer_keep(&offer, cases[i].asker, &peers);
        size_t count = 0;
        for (; count < 4 && cases[i].kept[count]; count++) {
            char part[64];
            g_snprintf(part, sizeof part, " %s ", cases[i].kept[count]);
            assert_non_null(strstr(offer.transport.candidates[count], part));
        }
        assert_int_equal(offer.transport.candidate_count, count);
        char *written = pel_whep_offer_write(&offer, true);
        good(written);
        g_free(written);
        g_string_free(text, TRUE);
    }
}

#define ANSWER                                                                 \
    "v=0\r\ns=-\r\na=group:BUNDLE v\r\nm=video 9 UDP/TLS/RTP/SAVPF 102\r\n"    \
    "a=ice-ufrag:ours\r\na=setup:active\r\na=mid:v\r\n"                        \
    "a=candidate:1 1 UDP 1 192.0.2.1 5 typ host\r\n"                           \
    "a=fmtp:102 packetization-mode=1\r\na=fmtp:103 apt=102\r\n"
#define PICTURES                                                               \
    "a=fmtp:102 level-asymmetry-allowed=1;packetization-mode=1\r\n"            \
    "a=fmtp:103 apt=102\r\n"

static void answers(const char *text, const char *wanted)
{
    good(text);
    char *said = pel_whep_answer_write(&offer, ANSWER, NULL);
    assert_string_equal(said, wanted);
    g_free(said);
}

/* Without a group there is a transport for the pictures alone. */
static void every_line_is_answered(void **state)
{
    (void)state;
    const uint32_t epoch = 4294967295u;
    const char *text =
        HEAD EMPTY "a=mid:a\r\n" MEDIA "a=mid:v\r\n"
                   "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n";
    answers(text, "v=0\r\ns=-\r\nm=audio 0 UDP/TLS/RTP/SAVPF 0\r\n"
                  "c=IN IP4 0.0.0.0\r\na=inactive\r\na=mid:a\r\n"
                  "m=video 9 UDP/TLS/RTP/SAVPF 102\r\na=ice-ufrag:ours\r\n"
                  "a=setup:active\r\na=mid:v\r\n"
                  "a=candidate:1 1 UDP 1 192.0.2.1 5 typ host\r\n" PICTURES
                  "a=end-of-candidates\r\n"
                  "m=application 0 UDP/DTLS/SCTP webrtc-datachannel\r\n"
                  "c=IN IP4 0.0.0.0\r\na=inactive\r\n");
    char *said = pel_whep_answer_write(&offer, ANSWER, &epoch);
    assert_non_null(strstr(said, "a=ts-refclk:private\r\n"
                                 "a=mediaclk:direct=4294967295\r\n"));
    g_free(said);
    assert_null(pel_whep_answer_write(&offer, "v=0\r\n", NULL));
}

#define SOUND                                                                  \
    "m=audio 9 UDP/TLS/RTP/SAVPF 111 "                                         \
    "0\r\na=ice-ufrag:Snd1\r\na=ice-pwd:" PASSWORD "\r\n" DTLS                 \
    "a=mid:a\r\na=rtpmap:0 PCMU/8000\r\n"                                      \
    "a=rtpmap:111 opus/48000/2\r\n" CANDIDATE
#define TRANSPORT "a=ice-ufrag:ours\r\na=setup:active\r\n"
#define CANDIDATES                                                             \
    "a=candidate:1 1 UDP 1 192.0.2.1 5 typ host\r\na=end-of-candidates\r\n"
#define SHARED                                                                 \
    "m=video 9 UDP/TLS/RTP/SAVPF 102\r\na=ice-ufrag:ours\r\n"                  \
    "a=setup:active\r\na=mid:v\r\n" PICTURES

/* The group's first line has the transport, and may not be refused. */
static void sound_first(void **state)
{
    (void)state;
    answers(HEAD
            "a=group:BUNDLE a v d\r\n" SOUND
            "m=video 0 UDP/TLS/RTP/SAVPF 102\r\na=bundle-only\r\n" MAP FORMAT
            "a=mid:v\r\n"
            "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n"
            "a=mid:d\r\n",
            "v=0\r\ns=-\r\na=group:BUNDLE a v\r\n"
            "m=audio 9 UDP/TLS/RTP/SAVPF 111\r\nc=IN IP4 0.0.0.0\r\n"
            "a=inactive\r\na=mid:a\r\na=rtcp-mux\r\n"
            "a=rtpmap:111 opus/48000/2\r\n" TRANSPORT CANDIDATES SHARED
            "m=application 0 UDP/DTLS/SCTP webrtc-datachannel\r\n"
            "c=IN IP4 0.0.0.0\r\na=inactive\r\na=mid:d\r\n");
    assert_string_equal(offer.transport.ufrag, "Snd1");
    assert_int_equal(offer.transport.candidate_count, 1);
    /* Data have no state without a transport. */
    answers(HEAD "a=group:BUNDLE d v w\r\n"
                 "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n"
                 "a=mid:d\r\n" ICE DTLS MEDIA "a=mid:v\r\n"
                 "m=video 9 UDP/TLS/RTP/SAVPF 96\r\na=mid:w\r\n"
                 "a=rtpmap:96 VP8/90000\r\n",
            "v=0\r\ns=-\r\na=group:BUNDLE d v w\r\n"
            "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n"
            "c=IN IP4 0.0.0.0\r\na=mid:d\r\n"
            "a=sctp-port:5000\r\n" TRANSPORT CANDIDATES SHARED
            "m=video 9 UDP/TLS/RTP/SAVPF 96\r\nc=IN IP4 0.0.0.0\r\n"
            "a=inactive\r\na=mid:w\r\na=rtcp-mux\r\n"
            "a=rtpmap:96 VP8/90000\r\n" TRANSPORT);
    /* A line that the offer has given up is not of the group. */
    answers(HEAD "a=group:BUNDLE a v\r\n"
                 "m=audio 0 UDP/TLS/RTP/SAVPF 111\r\na=mid:a\r\n" MEDIA
                 "a=mid:v\r\n",
            "v=0\r\ns=-\r\na=group:BUNDLE v\r\n"
            "m=audio 0 UDP/TLS/RTP/SAVPF 111\r\nc=IN IP4 0.0.0.0\r\n"
            "a=inactive\r\na=mid:a\r\n"
            "m=video 9 UDP/TLS/RTP/SAVPF 102\r\n" TRANSPORT
            "a=mid:v\r\na=candidate:1 1 UDP 1 192.0.2.1 5 typ host\r\n" PICTURES
            "a=end-of-candidates\r\n");
    bad(HEAD "a=group:BUNDLE a v\r\nm=audio 9 RTP/AVP 0\r\na=mid:a\r\n" MEDIA
             "a=mid:v\r\n",
        PEL_ERR_INVALID, "a=group:BUNDLE");
}

/* H.264 where there is any, as its encoder is shared with others. */
static void other_codec(void **state)
{
    (void)state;
    good(HEAD VIDEO ICE DTLS MAP FORMAT "a=rtpmap:96 VP8/90000\r\n");
    assert_false(offer.vp8);
    good(HEAD VIDEO ICE DTLS
         "a=rtpmap:96 VP9/90000\r\na=rtpmap:120 VP8/90000\r\n"
         "a=rtpmap:121 rtx/90000\r\na=fmtp:121 apt=120\r\n");
    assert_true(offer.vp8);
    assert_int_equal(offer.payload, 120);
    assert_int_equal(offer.rtx, 121);
    char *text = pel_whep_offer_write(&offer, false);
    assert_non_null(strstr(text, "a=rtpmap:120 VP8/90000\r\n"));
    assert_null(strstr(text, "packetization-mode"));
    good(text);
    assert_true(offer.vp8);
    g_free(text);
    /* H.264 in single NAL units is none that we make. */
    good(HEAD VIDEO ICE DTLS MAP "a=rtpmap:96 VP8/90000\r\n");
    assert_true(offer.vp8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chromium),
        cmocka_unit_test(firefox),
        cmocka_unit_test(gstreamer),
        cmocka_unit_test(what_is_missing_is_named),
        cmocka_unit_test(what_is_no_sdp_is_named_by_its_line),
        cmocka_unit_test(there_is_room_for_sixteen),
        cmocka_unit_test(sizes_of_words),
        cmocka_unit_test(payload_types),
        cmocka_unit_test(candidates),
        cmocka_unit_test(only_what_was_checked_is_written),
        cmocka_unit_test(few_are_sent_checks),
        cmocka_unit_test(every_line_is_answered),
        cmocka_unit_test(sound_first),
        cmocka_unit_test(other_codec),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

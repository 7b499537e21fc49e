/* The text that goes into the guest kernel, on a host that is made up: `ptrace` is one of a processor with HOST_BYTES of
 * registers, as Linux has it: reading gives as much as there is room for, writing wants the whole set (EFAULT), in which
 * no bit of XSTATE_BV is set that the process has no permission for (EINVAL). test_vcan_guest.py runs it. */
#include <elf.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/uio.h>

#define KEPT_BYTES 2696 /* HOST_FP_SIZE of Linux 6.1 */
#define XSTATE_BV 512
#define FORBIDDEN (1UL << 18) /* XTILEDATA: arch_prctl() has not been called */

static unsigned char registers[16384];
static size_t host_bytes;

static void panic(const char *format, int bytes)
{
	printf(format, bytes);
	exit(3);
}

static long made_up_ptrace(int request, int pid, int type, struct iovec *iov)
{
	unsigned long xstate_bv;

	if (pid != 1 || type != NT_X86_XSTATE)
		return errno = ESRCH, -1;
	if (iov->iov_len > host_bytes)
		iov->iov_len = host_bytes;
	if (request == PTRACE_GETREGSET) {
		memcpy(iov->iov_base, registers, iov->iov_len);
		return 0;
	}
	if (iov->iov_len != host_bytes)
		return errno = EFAULT, -1;
	memcpy(&xstate_bv, (char *)iov->iov_base + XSTATE_BV, sizeof(xstate_bv));
	if (xstate_bv & FORBIDDEN)
		return errno = EINVAL, -1;
	memcpy(registers, iov->iov_base, host_bytes);
	return 0;
}

#define ptrace made_up_ptrace
#include "host-xstate.h"

static void fill(unsigned char *bytes, size_t count, unsigned seed)
{
	for (size_t i = 0; i < count; ++i) {
		seed = seed * 1103515245 + 12345;
		bytes[i] = (unsigned char)(seed >> 16);
	}
}

static int require(int holds, const char *what)
{
	if (!holds)
		printf("host with %zu bytes: %s (errno %d)\n", host_bytes, what, errno);
	return holds;
}

int main(int argc, char **argv)
{
	unsigned long kept[2][KEPT_BYTES / sizeof(unsigned long)];
	unsigned long tiles = 3UL << 17, in_use = 0x2e7;
	int ok = argc == 2;

	host_bytes = ok ? strtoul(argv[1], NULL, 10) : 0;
	fill(registers, sizeof(registers), 1);
	ok = ok && require(ask_host_xstate(1) == 0, "cannot be asked");
	for (int process = 0; ok && process < 2; ++process) {
		fill((unsigned char *)kept[process], KEPT_BYTES, 7 + process);
		kept[process][XSTATE_BV / sizeof(unsigned long)] = in_use | (host_bytes > KEPT_BYTES && process == 0 ? tiles : 0);
	}
	for (int turn = 0; ok && turn < 6; ++turn) {
		unsigned long *mine = kept[turn % 2];
		size_t bytes = host_bytes < KEPT_BYTES ? host_bytes : KEPT_BYTES;

		ok = require(set_host_xstate(1, mine, KEPT_BYTES) == 0, "restoring failed");
		unsigned long *restored = (unsigned long *)registers;
		unsigned long wanted = mine[XSTATE_BV / sizeof(unsigned long)];
		if (host_bytes > KEPT_BYTES)
			wanted &= ~tiles;
		ok = ok && require(restored[XSTATE_BV / sizeof(unsigned long)] == wanted, "XSTATE_BV differs");
		restored[XSTATE_BV / sizeof(unsigned long)] = mine[XSTATE_BV / sizeof(unsigned long)];
		ok = ok && require(memcmp(registers, mine, bytes) == 0, "what was kept is not what was restored");
		for (size_t i = KEPT_BYTES; ok && i < host_bytes; ++i)
			ok = require(registers[i] == 0, "the padding is not empty");
		fill(registers, sizeof(registers), 100 + turn); /* another process ran */
	}
	return ok ? 0 : 1;
}

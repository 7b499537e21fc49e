/* host-xstate.h: the host's whole register set, for the guest kernel (arch/x86/um/os-Linux/registers.c includes it).
 *
 * The kernel keeps HOST_FP_SIZE bytes of a process' floating-point and vector registers. A host whose processor has
 * more (AMX: 11,008 bytes) gives these on PTRACE_GETREGSET, but PTRACE_SETREGSET wants its whole set, else EFAULT. So
 * what is kept is padded. What lies beyond are the tiles: in the padding they have their initial state, which the
 * cleared bits of XSTATE_BV say. Keeping more instead would overflow the kernel's stack, where thread_info holds a set.
 */
#define HOST_XSTATE_MAX 16384
#define HOST_XSTATE_BV 512 /* where XSTATE_BV stands in a set */
#define HOST_XSTATE_TILES (3UL << 17) /* XTILECFG, XTILEDATA */

static unsigned long host_xstate[HOST_XSTATE_MAX / sizeof(unsigned long)];
static unsigned long host_xstate_bytes;

/* Asks how large the host's set is. Once, before anything is restored. Returns 0, or -1 if there is no such set. */
static int ask_host_xstate(int pid)
{
	struct iovec iov = {.iov_base = host_xstate, .iov_len = sizeof(host_xstate)};

	if (ptrace(PTRACE_GETREGSET, pid, NT_X86_XSTATE, &iov) < 0)
		return -1;
	if (iov.iov_len == sizeof(host_xstate))
		panic("the host's register set has more than %d bytes (tools/guest/host-xstate.h)", HOST_XSTATE_MAX - 1);
	host_xstate_bytes = iov.iov_len;
	memset(host_xstate, 0, sizeof(host_xstate)); /* the padding, from now on */
	return 0;
}

/* Restores what was kept. Returns what ptrace returns. */
static long set_host_xstate(int pid, const void *kept, unsigned long kept_bytes)
{
	struct iovec iov = {.iov_base = host_xstate, .iov_len = host_xstate_bytes};

	memcpy(host_xstate, kept, kept_bytes);
	if (host_xstate_bytes > kept_bytes)
		host_xstate[HOST_XSTATE_BV / sizeof(unsigned long)] &= ~HOST_XSTATE_TILES;
	return ptrace(PTRACE_SETREGSET, pid, NT_X86_XSTATE, &iov);
}

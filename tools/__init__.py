# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writers of documents: the reference of the interface, SROS2 policies, tables in Markdown."""

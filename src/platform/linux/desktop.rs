//! What the desktop can show.

/// Whether windows can be see-through. A window that asks for it where no visual has an alpha channel does not open, so it is asked
/// for only on displays with a compositor.
#[must_use]
pub fn can_be_transparent() -> bool {
    if std::env::var_os("WAYLAND_DISPLAY").is_some_and(|display| !display.is_empty()) {
        return true;
    }
    has_compositor().unwrap_or(false)
}

/// Whether a window can open.
#[must_use]
pub fn has_display() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    is_set("DISPLAY") || is_set("WAYLAND_DISPLAY") || is_set("WAYLAND_SOCKET")
}

/// Whether a compositor runs on the X11 display, and the screen has a visual of 32 bits. None: there is no display.
fn has_compositor() -> Option<bool> {
    use x11rb::connection::Connection as _;
    use x11rb::protocol::xproto::ConnectionExt as _;

    let (connection, screen) = x11rb::connect(None).ok()?;
    let depths = &connection.setup().roots.get(screen)?.allowed_depths;
    let has_alpha = depths
        .iter()
        .any(|depth| depth.depth == 32 && !depth.visuals.is_empty());
    // A compositor owns this selection (Extended Window Manager Hints).
    let name = format!("_NET_WM_CM_S{screen}");
    let atom = connection.intern_atom(true, name.as_bytes()).ok()?;
    let atom = atom.reply().ok()?.atom;
    if atom == x11rb::NONE {
        return Some(false);
    }
    let owner = connection.get_selection_owner(atom).ok()?;
    Some(has_alpha && owner.reply().ok()?.owner != x11rb::NONE)
}

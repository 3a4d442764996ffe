extends RefCounted
## The look of Lumivox's panels in a game: dark glass with one warm accent.

const ACCENT := Color(0.96, 0.60, 0.42)
const TEXT := Color(0.90, 0.91, 0.93)
const GLASS := Color(0.055, 0.063, 0.078, 0.90)


## A theme for panels over a 3D scene.
static func create() -> Theme:
	var theme := Theme.new()
	theme.default_font_size = 13
	theme.set_color(&"accent_color", &"LumivoxEditor", ACCENT)
	for type: StringName in [&"Label", &"Button", &"CheckBox", &"LineEdit", &"OptionButton", &"PopupMenu", &"Tree"]:
		theme.set_color(&"font_color", type, TEXT)
	theme.set_stylebox(&"panel", &"PanelContainer", _box(GLASS, 10, 14, Color(1.0, 1.0, 1.0, 0.08)))
	for type: StringName in [&"PopupMenu", &"PopupPanel", &"TooltipPanel", &"AcceptDialog"]:
		theme.set_stylebox(&"panel", type, _box(Color(0.09, 0.10, 0.12), 8, 10, Color(1.0, 1.0, 1.0, 0.10)))
	theme.set_stylebox(&"hover", &"PopupMenu", _box(Color(1.0, 1.0, 1.0, 0.09), 5, 4))
	for type: StringName in [&"Button", &"OptionButton"]:
		theme.set_stylebox(&"normal", type, _box(Color(1.0, 1.0, 1.0, 0.07), 6, 7))
		theme.set_stylebox(&"hover", type, _box(Color(1.0, 1.0, 1.0, 0.13), 6, 7))
		theme.set_stylebox(&"pressed", type, _box(Color(ACCENT, 0.32), 6, 7))
		theme.set_stylebox(&"hover_pressed", type, _box(Color(ACCENT, 0.42), 6, 7))
		theme.set_stylebox(&"disabled", type, _box(Color(1.0, 1.0, 1.0, 0.03), 6, 7))
		theme.set_stylebox(&"focus", type, _box(Color(0.0, 0.0, 0.0, 0.0), 6, 7, Color(ACCENT, 0.5)))
		theme.set_color(&"font_pressed_color", type, Color.WHITE)
	# A box to tick is no button that is held down.
	for state: StringName in [&"normal", &"hover", &"pressed", &"hover_pressed", &"disabled"]:
		theme.set_stylebox(state, &"CheckBox", _box(Color(0.0, 0.0, 0.0, 0.0), 0, 2))
	theme.set_stylebox(&"normal", &"LineEdit", _box(Color(0.0, 0.0, 0.0, 0.35), 6, 6))
	theme.set_stylebox(&"read_only", &"LineEdit", _box(Color(0.0, 0.0, 0.0, 0.2), 6, 6))
	theme.set_stylebox(&"focus", &"LineEdit", _box(Color(0.0, 0.0, 0.0, 0.0), 6, 6, Color(ACCENT, 0.5)))
	theme.set_stylebox(&"slider", &"HSlider", _bar(Color(1.0, 1.0, 1.0, 0.12)))
	theme.set_stylebox(&"grabber_area", &"HSlider", _bar(Color(ACCENT, 0.85)))
	theme.set_stylebox(&"grabber_area_highlight", &"HSlider", _bar(ACCENT))
	theme.set_icon(&"grabber", &"HSlider", _knob(Color(0.93, 0.94, 0.95)))
	theme.set_icon(&"grabber_highlight", &"HSlider", _knob(Color.WHITE))
	theme.set_stylebox(&"background", &"ProgressBar", _box(Color(1.0, 1.0, 1.0, 0.08), 4, 0))
	theme.set_stylebox(&"fill", &"ProgressBar", _box(ACCENT, 4, 0))
	theme.set_constant(&"separation", &"VBoxContainer", 8)
	return theme


static func _box(color: Color, radius: int, margin: int, border := Color(0.0, 0.0, 0.0, 0.0)) -> StyleBoxFlat:
	var box := StyleBoxFlat.new()
	box.bg_color = color
	box.set_corner_radius_all(radius)
	box.content_margin_left = margin
	box.content_margin_right = margin
	box.content_margin_top = margin * 0.7 if margin < 10 else float(margin)
	box.content_margin_bottom = box.content_margin_top
	if border.a > 0.0:
		box.border_color = border
		box.set_border_width_all(1)
	return box


static func _bar(color: Color) -> StyleBoxFlat:
	var box := _box(color, 2, 0)
	box.content_margin_top = 2.0
	box.content_margin_bottom = 2.0
	return box


static func _knob(color: Color) -> Texture2D:
	var gradient := Gradient.new()
	gradient.offsets = PackedFloat32Array([0.0, 0.82, 0.98])
	gradient.colors = PackedColorArray([color, color, Color(color, 0.0)])
	var texture := GradientTexture2D.new()
	texture.gradient = gradient
	texture.fill = GradientTexture2D.FILL_RADIAL
	texture.fill_from = Vector2(0.5, 0.5)
	texture.fill_to = Vector2(1.0, 0.5)
	texture.width = 14
	texture.height = 14
	return texture

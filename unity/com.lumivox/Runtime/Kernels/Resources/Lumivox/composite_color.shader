// Made by `cargo xtask unity-kernels` from crates/lumivox-shaders: do not edit.
Shader "Hidden/Lumivox/composite_color"
{
    SubShader
    {
        Pass
        {
            Cull Off
            ZTest Always
            Blend One OneMinusSrcAlpha
            ZWrite Off

HLSLPROGRAM
#pragma target 4.5
#pragma vertex fullscreen
#pragma fragment composite_color

struct CompositeParams {
    uint width;
    uint padding_x;
    uint padding_y;
    uint padding_z;
};

static const uint TABLE_SIZE = 4096u;
static const uint TABLE_PAIRS = 12288u;
static const uint CLASS_PAIRS = 4u;
static const uint SHAPE_PAIRS = 8u;
static const uint STYLE_PAIRS = 8u;
static const uint CLIP_PLANE = 0u;
static const uint CLIP_BOX = 1u;
static const uint CLIP_SPHERE = 2u;
static const uint SET_OF_MANY = 8u;
static const uint BRICK_SIZE = 32u;
static const uint BRICK_TEXELS = 33u;
static const uint PAGE_BITS = 6u;
static const uint MAX_BRICKS = 128u;
static const uint MAX_POOLS = 4u;
static const uint MAX_EMPTY_DISTANCE = 16u;
static const uint IS_VOLUME = 2147483648u;
static const uint FILTER_NEAREST = 0u;
static const uint FILTER_TRILINEAR = 1u;
static const uint FILTER_TRICUBIC = 2u;
static const uint LIGHT_DIRECTIONAL = 0u;
static const uint LIGHT_POINT = 1u;
static const uint LIGHT_SPOT = 2u;
static const float MIN_LIGHT_DISTANCE = 0.001;
static const uint NONE_IS_ALONE = 4294967295u;
static const float PATH_NONE = 0.0;
static const float PATH_ASIDE = 1.0;
static const float PATH_STARVED = 2.0;
static const float PATH_STUCK = 3.0;
static const uint TOGETHER = 16u;
static const uint FINE_ALONE = 32u;
static const uint FOG_NONE = 0u;
static const uint FOG_EXPONENTIAL = 1u;
static const uint FOG_BETWEEN = 2u;
static const uint FOG_LINEAR_IN_DEPTH = 3u;
static const uint FOG_EXPONENTIAL_IN_DEPTH = 4u;
static const uint FOG_EXPONENTIAL_SQUARED_IN_DEPTH = 5u;
static const uint TONE_PLAIN = 0u;
static const uint TONE_AGX = 1u;
static const uint TONE_ACES = 2u;
static const uint BACKGROUND_TRANSPARENT = 0u;
static const uint BACKGROUND_COLOR = 1u;
static const uint BACKGROUND_ENVIRONMENT = 2u;

cbuffer params_buffer { CompositeParams params; }
ByteAddressBuffer picture_color;

struct FragmentInput_composite_color {
    float4 position_2 : SV_Position;
};

uint2 naga_f2u32(float2 value) {
    return uint2(clamp(value, 0.0, 4294967000.0));
}

uint pixel_at(float4 position_1)
{
    uint2 at = naga_f2u32(position_1.xy);
    uint _e6 = params.width;
    return ((at.y * _e6) + at.x);
}

float4 fullscreen(uint vertex : SV_VertexID) : SV_Position
{
    float2 corner = float2(float((vertex & 1u)), float((vertex >> 1u)));
    return float4(((corner * 4.0) - (1.0).xx), 0.0, 1.0);
}

float4 composite_color(FragmentInput_composite_color fragmentinput_composite_color) : SV_Target0
{
    float4 position = fragmentinput_composite_color.position_2;
    const uint _e2 = pixel_at(position);
    float4 color = asfloat(picture_color.Load4(_e2*16));
    if ((color.w <= 0.0)) {
        discard;
    }
    return color;
}
ENDHLSL
        }
    }
}
